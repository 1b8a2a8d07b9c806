(* (12) to (16): the weighted least-squares line of any continuous mu. The error (13) of the line b - a u has one
   minimum, at the a and b of (15), and a N is (16).
   Checked by Coq 8.16 or later with Coquelicot 3.2 (Debian: coq, libcoq-coquelicot): coqc least_squares.v *)
From Coq Require Import Reals Lra Psatz.
From Coquelicot Require Import Coquelicot.
Open Scope R_scope.

Section Fit.
Variables V : R.
Variable mu : R -> R.
Hypothesis V_positive : 0 < V.
Hypothesis mu_continuous : forall u, 0 <= u <= 2 * V -> continuous mu u.
Notation I f := (RInt f 0 (2 * V)).
Definition error a b := I (fun u => (V - u) ^ 2 * (a * u - b + mu u) ^ 2).
Definition a15 := 5 / (2 * V ^ 5) * I (fun u => (V - u) ^ 3 * mu u).
Definition b15 := 1 / (2 * V ^ 4) * I (fun u => (8 * V - 5 * u) * (V - u) ^ 2 * mu u).

Lemma in_range u : Rmin 0 (2 * V) <= u <= Rmax 0 (2 * V) -> 0 <= u <= 2 * V.
Proof. rewrite Rmin_left, Rmax_right; lra. Qed.

Definition I0 := I (fun u => (V - u) ^ 2 * mu u).
Definition I1 := I (fun u => u * (V - u) ^ 2 * mu u).
Definition I2 := I (fun u => (V - u) ^ 2 * mu u ^ 2).

Lemma integrable (p : R -> R) k : (forall u, continuous p u) -> ex_RInt (fun u => p u * mu u ^ k) 0 (2 * V).
Proof.
  intros Hp. apply (ex_RInt_continuous (V := R_CompleteNormedModule)). intros u Hu.
  apply (continuous_mult p (fun u => mu u ^ k)); [apply Hp |].
  induction k; simpl; [apply continuous_const |].
  apply (continuous_mult mu (fun u => mu u ^ k)); [apply mu_continuous, in_range, Hu | exact IHk].
Qed.

Lemma rise (p P : R -> R) : (forall u, is_derive P u (p u)) -> (forall u, continuous p u) ->
  is_RInt p 0 (2 * V) (P (2 * V) - P 0).
Proof. intros H1 H2. apply (is_RInt_derive P p); auto. Qed.

Ltac by_ring := intros; unfold plus, scal; simpl; unfold mult; simpl; match goal with |- @eq _ ?a ?b => change (@eq R a b) end; ring.
Ltac smooth := intro; apply (ex_derive_continuous (V := R_NormedModule)); auto_derive; exact Logic.I.

Lemma is_I0 : is_RInt (fun u => (V - u) ^ 2 * mu u) 0 (2 * V) I0.
Proof.
  apply (RInt_correct (V := R_CompleteNormedModule)).
  apply (ex_RInt_ext (fun u => (V - u) ^ 2 * mu u ^ 1)); [by_ring |].
  apply (integrable (fun u => (V - u) ^ 2)); smooth.
Qed.
Lemma is_I1 : is_RInt (fun u => u * (V - u) ^ 2 * mu u) 0 (2 * V) I1.
Proof.
  apply (RInt_correct (V := R_CompleteNormedModule)).
  apply (ex_RInt_ext (fun u => u * (V - u) ^ 2 * mu u ^ 1)); [by_ring |].
  apply (integrable (fun u => u * (V - u) ^ 2)); smooth.
Qed.
Lemma is_I2 : is_RInt (fun u => (V - u) ^ 2 * mu u ^ 2) 0 (2 * V) I2.
Proof.
  apply (RInt_correct (V := R_CompleteNormedModule)).
  apply (integrable (fun u => (V - u) ^ 2)); smooth.
Qed.

Lemma quadratic a b : error a b =
  a ^ 2 * (16 / 15 * V ^ 5) - 2 * a * b * (2 / 3 * V ^ 4) + b ^ 2 * (2 / 3 * V ^ 3) + 2 * a * I1 - 2 * b * I0 + I2.
Proof.
  apply is_RInt_unique.
  assert (Hp : is_RInt (fun u => (V - u) ^ 2 * (a * u - b) ^ 2) 0 (2 * V)
     (a ^ 2 * (16 / 15 * V ^ 5) - 2 * a * b * (2 / 3 * V ^ 4) + b ^ 2 * (2 / 3 * V ^ 3))).
  { pose (P := fun u => a ^ 2 * (V^2*u^3/3 - V*u^4/2 + u^5/5) - 2 * a * b * (V^2*u^2/2 - 2*V*u^3/3 + u^4/4)
                        + b ^ 2 * (V^2*u - V*u^2 + u^3/3)).
    replace (a ^ 2 * (16 / 15 * V ^ 5) - 2 * a * b * (2 / 3 * V ^ 4) + b ^ 2 * (2 / 3 * V ^ 3))
      with (P (2 * V) - P 0) by (unfold P; field).
    apply rise; [intro; unfold P; auto_derive; [exact Logic.I | field] | smooth]. }
  pose proof (is_RInt_plus _ _ _ _ _ _ Hp (is_RInt_plus _ _ _ _ _ _
    (is_RInt_plus _ _ _ _ _ _ (is_RInt_scal _ _ _ (2 * a) _ is_I1) (is_RInt_scal _ _ _ (- 2 * b) _ is_I0)) is_I2)) as H.
  eapply is_RInt_ext; [| replace (a ^ 2 * (16 / 15 * V ^ 5) - 2 * a * b * (2 / 3 * V ^ 4) + b ^ 2 * (2 / 3 * V ^ 3) + 2 * a * I1 - 2 * b * I0 + I2) with
    (plus (a ^ 2 * (16 / 15 * V ^ 5) - 2 * a * b * (2 / 3 * V ^ 4) + b ^ 2 * (2 / 3 * V ^ 3))
      (plus (plus (scal (2 * a) I1) (scal (- 2 * b) I0)) I2)); [exact H |]].
  - by_ring.
  - by_ring.
Qed.

Lemma a_is : a15 = 5 / (2 * V ^ 5) * (V * I0 - I1).
Proof.
  unfold a15. f_equal. apply is_RInt_unique.
  pose proof (is_RInt_plus _ _ _ _ _ _ (is_RInt_scal _ _ _ V _ is_I0) (is_RInt_scal _ _ _ (- 1) _ is_I1)) as H.
  eapply is_RInt_ext; [| replace (V * I0 - I1) with (plus (scal V I0) (scal (- 1) I1)); [exact H |]].
  - by_ring.
  - by_ring.
Qed.
Lemma b_is : b15 = 1 / (2 * V ^ 4) * (8 * V * I0 - 5 * I1).
Proof.
  unfold b15. f_equal. apply is_RInt_unique.
  pose proof (is_RInt_plus _ _ _ _ _ _ (is_RInt_scal _ _ _ (8 * V) _ is_I0) (is_RInt_scal _ _ _ (- 5) _ is_I1)) as H.
  eapply is_RInt_ext; [| replace (8 * V * I0 - 5 * I1) with (plus (scal (8 * V) I0) (scal (- 5) I1)); [exact H |]].
  - by_ring.
  - by_ring.
Qed.

Theorem eq15 a b : error a15 b15 <= error a b /\ (error a15 b15 = error a b -> a = a15 /\ b = b15).
Proof.
  assert (gap : error a b - error a15 b15 =
     2 / 3 * V ^ 3 * ((b - b15 - V * (a - a15)) ^ 2) + 2 / 5 * V ^ 5 * (a - a15) ^ 2).
  { rewrite !quadratic, a_is, b_is. field. lra. }
  assert (0 < V ^ 3) by (apply pow_lt; lra). assert (0 < V ^ 5) by (apply pow_lt; lra).
  pose proof (pow2_ge_0 (a - a15)). pose proof (pow2_ge_0 (b - b15 - V * (a - a15))).
  assert (0 <= V ^ 3 * (b - b15 - V * (a - a15)) ^ 2) by (apply Rmult_le_pos; lra).
  assert (0 <= V ^ 5 * (a - a15) ^ 2) by (apply Rmult_le_pos; lra).
  split; [lra |]. intro E.
  assert (V ^ 3 * (b - b15 - V * (a - a15)) ^ 2 = 0) as E1 by lra.
  assert (V ^ 5 * (a - a15) ^ 2 = 0) as E2 by lra.
  apply Rmult_integral in E2. destruct E2 as [? | E2]; [lra |].
  apply Rmult_integral in E1. destruct E1 as [? | E1]; [lra |].
  assert (a - a15 = 0) as Ea by (destruct (Req_dec (a - a15) 0) as [| n]; auto; pose proof (pow_nonzero _ 2 n); lra).
  rewrite Ea in E1.
  assert (b - b15 - V * 0 = 0) as Eb by (destruct (Req_dec (b - b15 - V * 0) 0) as [| n]; auto; pose proof (pow_nonzero _ 2 n); lra).
  lra.
Qed.

Theorem eq16 N : is_RInt (fun u => 5 * N / (2 * V ^ 5) * ((V - u) ^ 3 * mu u)) 0 (2 * V) (a15 * N).
Proof.
  replace (a15 * N) with (scal (5 * N / (2 * V ^ 5)) (I (fun u => (V - u) ^ 3 * mu u))).
  - apply (is_RInt_scal (fun u => (V - u) ^ 3 * mu u)). apply (RInt_correct (V := R_CompleteNormedModule)).
    apply (ex_RInt_ext (fun u => (V - u) ^ 3 * mu u ^ 1)); [by_ring |]. apply (integrable (fun u => (V - u) ^ 3)); smooth.
  - change (5 * N / (2 * V ^ 5) * I (fun u => (V - u) ^ 3 * mu u) = a15 * N). unfold a15. field. lra.
Qed.
End Fit.
Check eq15.
Check eq16.
Print Assumptions eq15.
