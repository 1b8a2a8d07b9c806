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
${note}Theorem criterion : ${conditions}is_derive mu V (- c / N).
Proof.
  intros. $cases
Qed.
(*# weight *)
Definition w (s : R) : R := 2 / PI * sqrt (1 - s ^ 2).

(*# pole *)
Lemma $pole : is_RInt (fun t => $fraction) 0 PI ($integral).
Proof. ${facts}unfold speed. apply ($lemma); first [positive | with_roots (field$using)]. Qed.
(*# angle *)
(* ---- A term of the slope: a function whose derivative it is but for its poles, and its integral ---- *)
Definition slope$label (v : R) : R := $slope.
Definition rise$label (t : R) : R := $rise.
Definition I$label : R := $value.
$poles
Lemma rest$label : is_RInt (fun t => sin t ^ 2 * slope$label (speed t)$remaining) 0 PI (rise$label PI - rise$label 0).
Proof.
  apply (rise_of rise$label); intro t; pose proof (speed_low t); pose proof (sine_squared t) as Q;$positive
    pose proof (COS_bound t) as [cos_low cos_high]; unfold slope$label, speed in *.
  - unfold rise$label. auto_derive; [positive | field [Q]; positive].
  - apply (ex_derive_continuous (V := R_NormedModule)). auto_derive. positive.
Qed.
Lemma angle$label : is_RInt (fun t => sin t ^ 2 * slope$label (speed t)) 0 PI I$label.
Proof.
  replace I$label with (rise$label PI - rise$label 0$risen) by (unfold I$label, rise$label; rewrite ?sin_PI, ?sin_0; unfold Rdiv; ring).
  apply (is_RInt_ext (fun t => sin t ^ 2 * slope$label (speed t)$remaining$restored)).
  - intros t _. change_to_reals. ring.
  - exact $integrals.
Qed.

(*# share_over_angle *)
Lemma share$label : $share = - N * (2 / PI) * ($amplitude * I$label).
Proof.
  $equality
Qed.
(*# harmonic *)
(* ---- The proof, over the angle t of v = V (1 - cos t) ---- *)
Definition speed (t : R) : R := V * (1 - cos t).
Lemma speed_low t : 0 <= speed t.
Proof. pose proof (COS_bound t). unfold speed. apply Rmult_le_pos; lra. Qed.
$terms
(* ---- The slope is the sum of its terms, and c that of their integrals ---- *)
Definition slope (v : R) : R := $slope.
Lemma slope_is v : 0 <= v -> Derive mu v = slope v.
Proof. intro v_low. apply is_derive_unique. unfold mu, slope, $slopes. auto_derive; [positive | field; positive]. Qed.
$shares
Lemma c_is : c = - N * (2 / PI) * ($values).
Proof.
  $c_equality
Qed.
Lemma by_angle : is_RInt (fun t => - N * (2 / PI) * (sin t ^ 2 * slope (speed t))) 0 PI c.
Proof.
  rewrite c_is. apply integral_times, (is_RInt_ext (fun t => $integrand)).
  - intros t _. change_to_reals. unfold slope. ring.
  - exact $integrals.
Qed.
Definition integrand (v : R) : R := - N * w (v / V - 1) * slope v / V.
Lemma integrand_continuous v : 0 <= v -> continuous integrand v.
Proof.
  intro v_low. apply (continuous_mult (fun v => - N * w (v / V - 1) * slope v) (fun _ => / V)); [| apply continuous_const].
  apply (continuous_mult (fun v => - N * w (v / V - 1)) slope).
  - apply (continuous_mult (fun _ => - N)); [apply continuous_const |].
    apply (continuous_mult (fun _ => 2 / PI)); [apply continuous_const |].
    apply (continuous_comp (fun v => 1 - (v / V - 1) ^ 2) sqrt); [| apply continuous_sqrt].
    apply (ex_derive_continuous (V := R_NormedModule)). auto_derive. positive.
  - apply (ex_derive_continuous (V := R_NormedModule)). unfold slope, $slopes. auto_derive. positive.
Qed.
Lemma over_speed : is_RInt integrand 0 (2 * V) c.
Proof.
  pose proof PI_RGT_0.
  assert (S : is_RInt (fun t => scal (V * sin t) (integrand (speed t))) 0 PI (RInt integrand (speed 0) (speed PI))).
  { apply (is_RInt_comp (V := R_CompleteNormedModule) integrand speed (fun t => V * sin t)); intros t _.
    - apply integrand_continuous, speed_low.
    - split; [unfold speed; auto_derive; [exact Logic.I | ring] |].
      apply (ex_derive_continuous (V := R_NormedModule)). auto_derive. exact Logic.I. }
  replace (speed 0) with 0 in S by (unfold speed; rewrite cos_0; ring).
  replace (speed PI) with (2 * V) in S by (unfold speed; rewrite cos_PI; ring).
  assert (T : is_RInt (fun t => - N * (2 / PI) * (sin t ^ 2 * slope (speed t))) 0 PI (RInt integrand 0 (2 * V))).
  { revert S. apply is_RInt_ext. rewrite Rmin_left, Rmax_right by lra. intros t Ht.
    change (V * sin t * integrand (speed t) = - N * (2 / PI) * (sin t ^ 2 * slope (speed t))).
    unfold integrand, w. replace (1 - (speed t / V - 1) ^ 2) with (sin t ^ 2).
    - rewrite sqrt_pow2 by (apply Rlt_le, sin_gt_0; lra). field; positive.
    - pose proof (sine_squared t). unfold speed. replace (V * (1 - cos t) / V - 1) with (- cos t) by (field; positive). lra. }
  replace c with (RInt integrand 0 (2 * V)).
  - apply (RInt_correct (V := R_CompleteNormedModule)), ex_RInt_continuous. intros v range. apply integrand_continuous.
    rewrite Rmin_left in range by lra. lra.
  - rewrite <- (is_RInt_unique _ _ _ _ T). exact (is_RInt_unique _ _ _ _ by_angle).
Qed.
Theorem criterion : is_RInt (fun v => - N * w (v / V - 1) * Derive mu v / V) 0 (2 * V) c.
Proof.
  apply (is_RInt_ext integrand); [| exact over_speed].
  intros v range. rewrite Rmin_left in range by lra. unfold integrand. rewrite slope_is by lra. reflexivity.
Qed.
