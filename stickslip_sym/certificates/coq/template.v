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
(*# weight *)
Definition w (s : R) : R := 2 / PI * sqrt (1 - s ^ 2).

(*# harmonic *)
(* ---- The proof, over the angle t of v = V (1 - cos t) ---- *)
Definition slope (v : R) : R := $slope.
Definition speed (t : R) : R := V * (1 - cos t).
Definition rise (t : R) : R := - N * (2 / PI) * ($rise).
Definition integrand (v : R) : R := - N * w (v / V - 1) * Derive mu v / V.
Definition over_angle (t : R) : R := - N * (2 / PI) * (sin t ^ 2 * slope (speed t)).
Lemma slope_is v : Derive mu v = slope v.
Proof. apply is_derive_unique. unfold mu, slope. auto_derive; [exact Logic.I | field; positive]. Qed.
Lemma integrand_continuous v : continuous integrand v.
Proof.
  apply (continuous_ext (fun v => - N * (2 / PI * sqrt (1 - (v / V - 1) ^ 2)) * slope v * / V)).
  { intro y. unfold integrand, w. rewrite slope_is. reflexivity. }
  apply (continuous_mult (fun v => - N * (2 / PI * sqrt (1 - (v / V - 1) ^ 2)) * slope v) (fun _ => / V)); [| apply continuous_const].
  apply (continuous_mult (fun v => - N * (2 / PI * sqrt (1 - (v / V - 1) ^ 2))) slope).
  - apply (continuous_mult (fun _ => - N)); [apply continuous_const |].
    apply (continuous_mult (fun _ => 2 / PI)); [apply continuous_const |].
    apply (continuous_comp (fun v => 1 - (v / V - 1) ^ 2) sqrt); [| apply continuous_sqrt].
    apply (ex_derive_continuous (V := R_NormedModule)). auto_derive. positive.
  - apply (ex_derive_continuous (V := R_NormedModule)). unfold slope. auto_derive. exact Logic.I.
Qed.
Lemma by_angle : is_RInt over_angle 0 PI c.
Proof.
  pose proof PI_RGT_0. replace c with (minus (rise PI) (rise 0)).
  - apply (is_RInt_derive rise over_angle); intros t _.
    + unfold rise, over_angle, slope, speed. auto_derive; [exact Logic.I |].
      assert (Q : sin t * sin t = 1 - cos t * cos t) by (pose proof (sin2_cos2 t) as E; unfold Rsqr in E; lra).
      field [Q]; positive.
    + apply (ex_derive_continuous (V := R_NormedModule)). unfold over_angle, slope, speed. auto_derive. exact Logic.I.
  - change (rise PI - rise 0 = c). unfold rise, c. rewrite ?sin_PI, ?cos_PI, ?sin_0, ?cos_0. field; positive.
Qed.
Theorem criterion : is_RInt (fun v => - N * w (v / V - 1) * Derive mu v / V) 0 (2 * V) c.
Proof.
  pose proof PI_RGT_0.
  assert (S : is_RInt (fun t => scal (V * sin t) (integrand (speed t))) 0 PI (RInt integrand (speed 0) (speed PI))).
  { apply (is_RInt_comp (V := R_CompleteNormedModule) integrand speed (fun t => V * sin t)); intros t _.
    - apply integrand_continuous.
    - split; [unfold speed; auto_derive; [exact Logic.I | ring] |].
      apply (ex_derive_continuous (V := R_NormedModule)). auto_derive. exact Logic.I. }
  replace (speed 0) with 0 in S by (unfold speed; rewrite cos_0; ring).
  replace (speed PI) with (2 * V) in S by (unfold speed; rewrite cos_PI; ring).
  assert (T : is_RInt over_angle 0 PI (RInt integrand 0 (2 * V))).
  { revert S. apply is_RInt_ext. rewrite Rmin_left, Rmax_right by lra. intros t Ht.
    change (V * sin t * integrand (speed t) = over_angle t).
    unfold integrand, over_angle, w. rewrite slope_is. replace (1 - (speed t / V - 1) ^ 2) with (sin t ^ 2).
    - rewrite sqrt_pow2 by (apply Rlt_le, sin_gt_0; lra). field; positive.
    - pose proof (sin2_cos2 t) as E. unfold Rsqr in E. unfold speed.
      replace (V * (1 - cos t) / V - 1) with (- cos t) by (field; positive). lra. }
  change (is_RInt integrand 0 (2 * V) c). replace c with (RInt integrand 0 (2 * V)).
  - apply (RInt_correct (V := R_CompleteNormedModule)), ex_RInt_continuous. intros x _. apply integrand_continuous.
  - rewrite <- (is_RInt_unique _ _ _ _ T). exact (is_RInt_unique _ _ _ _ by_angle).
Qed.
