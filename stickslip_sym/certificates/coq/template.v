(*# head *)
(* $title

   Checked by Coq 8.16 or later with Coquelicot 3.2 (Debian: coq, libcoq-coquelicot): coqc FILE.v.
   To be read: the definitions of mu, K and c, and the theorem that Check prints at the end. All else serves its proof;
   Print Assumptions names what the proof rests on: the axioms of Coq's real numbers. *)
From Coq Require Import Reals Lra Psatz.
From Coquelicot Require Import Coquelicot.
Open Scope R_scope.

$library
(*# law *)
(* ---- The law and the criterion ---- *)
$kernel
Section Law.
Variables $letters : R.
$hypotheses
Definition mu (v : R) : R := $mu.
Definition c : R := $c.

(*# end *)
End Law.
Check criterion.
Print Assumptions criterion.
(*# kernel *)
Definition K (V v : R) : R := $kernel.
Lemma K_at_scale s V v : 0 < s -> 0 < V -> K (V / s) (v / s) = s ^ 2 * K V v.
Proof. intros. unfold K. field; positive. Qed.
(*# average *)
(* ---- The average of a profile, speeds in units of its scale: antiderivatives, and what they rise by ---- *)
Section Average$label.
Variables $variables : R.
$hypotheses
Definition g$label (u : R) : R := $profile.
Definition I$label : R := $value.
$definitions
$pieces
Lemma average$label : is_RInt (fun u => g$label u * K r u) 0 (2 * r) I$label.
Proof.
  replace I$label with ($rises); [exact $joined |].
  unfold $unfolded. $equality
Qed.
End Average$label.

(*# closed *)
Lemma piece$label : is_RInt (fun u => ($piece) * K r u) $low $high (A$label $high - A$label $low).
Proof.
  assert (0 <= $low <= $high /\ $high <= 2 * r) as [ends ends'] by $order.
  apply (is_RInt_derive A$label); intros u range; rewrite Rmin_left, Rmax_right in range by lra;
    assert (0 <= u <= 2 * r) as [u_low u_high] by lra.
  - $derivative
  - apply (ex_derive_continuous (V := R_NormedModule)). unfold K$unfolded. auto_derive. positive.
Qed.
(*# open *)
Lemma piece$label : is_RInt (fun u => ($piece) * K r u) $low $high (A$label $high - A$label $low).
Proof.
  assert (0 <= $low <= $high /\ $high <= 2 * r) as [ends ends'] by $order.
  apply (rise_between A$label); [lra | | |]; intro u.
  - intro range. assert (0 < u < 2 * r) as [u_low u_high] by lra. $derivative
  - intro range. assert (0 <= u <= 2 * r) as [u_low u_high] by lra. unfold A$label. continuous.
  - intro range. assert (0 <= u <= 2 * r) as [u_low u_high] by lra. unfold K$unfolded. continuous.
Qed.
(*# within *)
Lemma within$label : is_RInt (fun u => g$profile u * K r u) $low $high (A$label $high - A$label $low).
Proof.
  assert ($low <= $high) as ends by $order.
  apply (is_RInt_ext (V := R_NormedModule)) with (2 := piece$label). intros u range.
  rewrite Rmin_left, Rmax_right in range by exact ends. apply (f_equal (fun y => y * K r u)). symmetry. $same
Qed.
(*# term *)
Lemma term$label : is_RInt (fun v => $profile (v / $scale) * K V v) 0 (2 * V) ($value).
Proof.
  apply (at_scale ($profile)); [positive | intro; apply K_at_scale; positive | apply average$average; positive].
Qed.
(*# sum *)
Lemma mu_is v : 0 <= v -> mu v = $terms.
Proof.
  intro v_low. $mu_equality
Qed.
$shares
Lemma c_is : c$boundary = N * ($values).
Proof.
  $c_equality
Qed.
Theorem criterion : is_RInt (fun v => N * mu v * K V v) 0 (2 * V) (c$boundary).
Proof.
  rewrite c_is. apply (is_RInt_ext (fun v => N * ($integrand))).
  - intros v range. rewrite Rmin_left, Rmax_right in range by lra. rewrite mu_is by lra. change_to_reals. ring.
  - exact (integral_times N _ _ _ _ $integrals).
Qed.
(*# share *)
Lemma share$label : $share = N * ($values).
Proof.
  $equality
Qed.
(*# slope *)
Lemma slope$label : ${conditions}is_derive mu V (- c / N).
Proof.
  intros. apply (is_derive_ext_loc (fun v => $piece)).
  - $nearby
  - replace c with ($c) by (unfold c; ${cases}first [reflexivity | field; positive]).
    ${facts}auto_derive; [positive | $moves].
Qed.
(*# slopes *)
Theorem criterion : ${conditions}is_derive mu V (- c / N).
Proof.
  intros. $cases
Qed.
