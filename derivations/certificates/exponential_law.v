(* The exponential law (3): the criterion (16) is (17), as the paper prints it, and so is the average of slopes.
   Checked by Coq 8.16 or later with Coquelicot 3.2 (Debian: coq, libcoq-coquelicot): coqc exponential_law.v *)
From Coq Require Import Reals Lra.
From Coquelicot Require Import Coquelicot.
Open Scope R_scope.

Section Exponential.
Variables V N mu_s mu_m alpha : R.
Hypothesis V_positive : 0 < V.
Hypothesis alpha_positive : 0 < alpha.

Definition mu v := mu_m + (mu_s - mu_m) * exp (- alpha * v).
Definition slope v := - alpha * (mu_s - mu_m) * exp (- alpha * v).
Definition weight s := 5 / 8 * (1 - s ^ 4).
Definition c17 := 5 * N * (mu_s - mu_m) * exp (- alpha * V) *
  ((6 * (alpha * V) + (alpha * V) ^ 3) * cosh (alpha * V) - (6 + 3 * (alpha * V) ^ 2) * sinh (alpha * V))
  / (V ^ 5 * alpha ^ 4).

(* (17) by one exponential *)
Lemma by_exponential : c17 = 5 * N * (mu_s - mu_m) / (2 * alpha ^ 4 * V ^ 5) *
  (alpha ^ 3 * V ^ 3 - 3 * alpha ^ 2 * V ^ 2 + 6 * alpha * V - 6
   + (alpha ^ 3 * V ^ 3 + 3 * alpha ^ 2 * V ^ 2 + 6 * alpha * V + 6) * exp (- 2 * alpha * V)).
Proof.
  unfold c17, cosh, sinh. pose proof (exp_pos (- (alpha * V))).
  replace (- 2 * alpha * V) with (- (alpha * V) + - (alpha * V)) by ring.
  replace (- alpha * V) with (- (alpha * V)) by ring.
  replace (exp (alpha * V)) with (/ exp (- (alpha * V))) by (rewrite exp_Ropp, Rinv_inv; reflexivity).
  rewrite exp_plus. field. repeat split; lra.
Qed.

Definition A v := 5 * N / (2 * V ^ 5) *
  (- mu_m * (V - v) ^ 4 / 4
   + (mu_s - mu_m) * exp (- alpha * v) * (- (V - v) ^ 3 / alpha + 3 * (V - v) ^ 2 / alpha ^ 2
      - 6 * (V - v) / alpha ^ 3 + 6 / alpha ^ 4)).

Theorem eq17 : is_RInt (fun v => 5 * N / (2 * V ^ 5) * (V - v) ^ 3 * mu v) 0 (2 * V) c17.
Proof.
  rewrite by_exponential. match goal with |- is_RInt ?f _ _ ?c => replace c with (minus (A (2 * V)) (A 0)) end.
  - apply (is_RInt_derive A); intros v _.
    + unfold A, mu. auto_derive; [repeat split; try lra | field; repeat split; lra].
    + apply (ex_derive_continuous (V := R_NormedModule)). unfold mu. auto_derive. repeat split; lra.
  - unfold A, minus, plus, opp; simpl.
    replace (- alpha * (2 * V)) with (- 2 * alpha * V) by ring.
    replace (- alpha * 0) with 0 by ring. rewrite exp_0. field; repeat split; lra.
Qed.

Lemma slope_of_mu v : is_derive mu v (slope v).
Proof. unfold mu, slope. auto_derive; [exact Logic.I | ring]. Qed.

Definition B s := N * alpha * (mu_s - mu_m) * - exp (- alpha * (V * (1 + s))) *
  (5 / 8 * (1 - s ^ 4) / (alpha * V) - 5 / 2 * s ^ 3 / (alpha * V) ^ 2 - 15 / 2 * s ^ 2 / (alpha * V) ^ 3
   - 15 * s / (alpha * V) ^ 4 - 15 / (alpha * V) ^ 5).

Theorem slope_average : is_RInt (fun s => - N * (weight s * slope (V * (1 + s)))) (- 1) 1 c17.
Proof.
  rewrite by_exponential. match goal with |- is_RInt ?f _ _ ?c => replace c with (minus (B 1) (B (- 1))) end.
  - apply (is_RInt_derive B); intros s _.
    + unfold B, weight, slope. auto_derive; [repeat split; try lra | field; repeat split; lra].
    + apply (ex_derive_continuous (V := R_NormedModule)). unfold weight, slope. auto_derive. repeat split; lra.
  - unfold B, minus, plus, opp; simpl.
    replace (- alpha * (V * (1 + 1))) with (- 2 * alpha * V) by ring.
    replace (- alpha * (V * (1 + - 1))) with 0 by ring. rewrite exp_0. field; repeat split; lra.
Qed.
End Exponential.
Check eq17.
Check slope_average.
Print Assumptions eq17.
