(* The polynomial law (4): the criterion (16) is (18), which vanishes at V = sqrt(21/26) v_m.
   Checked by Coq 8.16 or later with Coquelicot 3.2 (Debian: coq, libcoq-coquelicot): coqc polynomial_law.v *)
From Coq Require Import Reals Lra Psatz.
From Coquelicot Require Import Coquelicot.
Open Scope R_scope.

Section Polynomial.
Variables V N mu_s mu_m v_m : R.
Hypothesis V_positive : 0 < V.
Hypothesis v_m_positive : 0 < v_m.

Definition mu v := mu_s - 3 * (mu_s - mu_m) / (2 * v_m) * v + (mu_s - mu_m) / (2 * v_m ^ 3) * v ^ 3.
Definition c18 := (mu_s - mu_m) * N * (21 * v_m ^ 2 - 26 * V ^ 2) / (14 * v_m ^ 3).

Definition A v := 5 * N / (2 * V ^ 5) *
  (mu_s * (V ^ 3 * v - 3 * V ^ 2 * v ^ 2 / 2 + V * v ^ 3 - v ^ 4 / 4)
   - 3 * (mu_s - mu_m) / (2 * v_m) * (V ^ 3 * v ^ 2 / 2 - V ^ 2 * v ^ 3 + 3 * V * v ^ 4 / 4 - v ^ 5 / 5)
   + (mu_s - mu_m) / (2 * v_m ^ 3) * (V ^ 3 * v ^ 4 / 4 - 3 * V ^ 2 * v ^ 5 / 5 + V * v ^ 6 / 2 - v ^ 7 / 7)).

Theorem eq18 : is_RInt (fun v => 5 * N / (2 * V ^ 5) * (V - v) ^ 3 * mu v) 0 (2 * V) c18.
Proof.
  replace c18 with (minus (A (2 * V)) (A 0)).
  - apply (is_RInt_derive A); intros v _.
    + unfold A, mu. auto_derive; [repeat split; try lra | field; repeat split; lra].
    + apply (ex_derive_continuous (V := R_NormedModule)). unfold mu. auto_derive. repeat split; lra.
  - unfold A, c18, minus, plus, opp; simpl. field; repeat split; lra.
Qed.

Theorem transition_speed : V = sqrt (21 / 26) * v_m -> c18 = 0.
Proof.
  intro E. unfold c18. replace (V ^ 2) with (21 / 26 * v_m ^ 2); [field; lra |].
  rewrite E, Rpow_mult_distr. f_equal. simpl. rewrite Rmult_1_r, sqrt_sqrt; lra.
Qed.
End Polynomial.
Check eq18.
Print Assumptions eq18.
