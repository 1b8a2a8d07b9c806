(*# hyperbolic *)
Lemma tanh_is x : tanh x = (1 - exp (- 2 * x)) / (1 + exp (- 2 * x)).
Proof.
  unfold tanh, sinh, cosh. replace (-2 * x) with (- x + - x) by ring. rewrite exp_plus, exp_Ropp.
  pose proof (exp_pos x). field. split; nra.
Qed.
Lemma cosh_is x : cosh x = (1 + exp (- 2 * x)) / (2 * exp (- x)).
Proof.
  unfold cosh. replace (-2 * x) with (- x + - x) by ring. rewrite exp_plus, exp_Ropp.
  pose proof (exp_pos x). field. lra.
Qed.
Lemma sinh_is x : sinh x = (1 - exp (- 2 * x)) / (2 * exp (- x)).
Proof.
  unfold sinh. replace (-2 * x) with (- x + - x) by ring. rewrite exp_plus, exp_Ropp.
  pose proof (exp_pos x). field. lra.
Qed.
Lemma cosh_positive x : 0 < cosh x.
Proof. unfold cosh. pose proof (exp_pos x). pose proof (exp_pos (- x)). lra. Qed.
Global Instance UnaryDiff_cosh : UnaryDiff cosh.
Proof. exists sinh. intro x. unfold cosh, sinh. auto_derive; [exact Logic.I | field]. Defined.
Global Instance UnaryDiff_sinh : UnaryDiff sinh.
Proof. exists cosh. intro x. unfold cosh, sinh. auto_derive; [exact Logic.I | field]. Defined.
Global Instance UnaryDiff_tanh : UnaryDiff tanh.
Proof.
  exists (fun x => 1 - tanh x ^ 2). intro x. pose proof (cosh_positive x). unfold tanh.
  auto_derive; [lra | unfold cosh, sinh in *; field; lra].
Defined.
Global Typeclasses Opaque tanh sinh cosh.

(*# tactics *)
(* "Typeclasses Opaque" keeps auto_derive from unfolding a function to tell it from those whose derivatives it knows *)
Lemma exp_le y z : y <= z -> exp y <= exp z.
Proof. intros [H | ->]; [apply Rlt_le, exp_increasing, H | apply Rle_refl]. Qed.
Ltac positive := first [ assumption | exact Logic.I | lra | exact PI_RGT_0 | apply exp_pos | match goal with
  | |- _ /\ _ => split; positive
  | |- _ <> 0 => first [ apply Rgt_not_eq; unfold Rgt; solve [positive] | apply Rlt_not_eq; solve [positive] ]
  | |- - _ < 0 => apply Ropp_lt_gt_0_contravar; positive
  | |- _ > _ => unfold Rgt; positive
  | |- 0 < _ + _ => first [ solve [apply Rplus_lt_le_0_compat; positive] | solve [apply Rplus_le_lt_0_compat; positive] ]
  | |- 0 <= _ + _ => apply Rplus_le_le_0_compat; positive
  | |- 0 < _ * _ => apply Rmult_lt_0_compat; positive
  | |- 0 <= _ * _ => apply Rmult_le_pos; positive
  | |- 0 < / _ => apply Rinv_0_lt_compat; positive
  | |- 0 <= / _ => apply Rlt_le, Rinv_0_lt_compat; positive
  | |- 0 < _ / _ => apply Rdiv_lt_0_compat; positive
  | |- 0 <= _ / _ => apply Rdiv_le_0_compat; positive
  | |- 0 < _ ^ _ => apply pow_lt; positive
  | |- 0 <= _ ^ _ => apply pow_le; positive
  | |- 0 < cosh _ => apply cosh_positive  (*? hyperbolic *)
  | |- 0 < sqrt _ => apply sqrt_lt_R0; positive
  | |- 0 <= sqrt _ => apply sqrt_pos
  | H : ?a <> 0 |- ?b <> 0 => solve [intro E; apply H; lra]
  | |- _ * _ <> 0 => apply Rmult_integral_contrapositive_currified; positive
  | |- _ ^ _ <> 0 => apply pow_nonzero; positive
  | |- exp _ < 2 => apply (Rle_lt_trans _ (exp 0)); [apply exp_le, Ropp_le_cancel; rewrite Ropp_0, <- ?Ropp_mult_distr_l, Ropp_involutive; positive | rewrite exp_0; lra]
  | |- 0 < Rmin _ _ => apply Rmin_glb_lt; positive
  | |- 0 <= Rmin _ _ => apply Rmin_glb; positive
  end | nra ].
Ltac equal := solve [ field; positive | ring ].
Ltac change_to_reals := match goal with |- @eq _ ?a ?b => change (@eq R a b) end.
Ltac square_of_root := apply sqrt_sqrt; solve [apply Rlt_le; positive | lra | positive].
(* equal arguments of a function have one text; each two are compared once *)
Ltac arguments f found := match goal with
  | |- context [f ?a] => match found with context [cons a _] => fail 1 | _ => arguments f constr:(cons a found) end
  | _ => found end.
Ltac take_for f a others t := lazymatch others with nil => idtac | cons ?b ?rest =>
  try (tryif constr_eq a b then fail else (lazymatch goal with |- context [f b] => idtac end; replace (f b) with (f a) by (f_equal; t)));
  take_for f a rest t end.
Ltac take_each f all t := lazymatch all with nil => idtac | cons ?a ?rest => take_for f a rest t; take_each f rest t end.
Tactic Notation "same" constr(f) "by" tactic3(t) := let all := arguments f (@nil R) in take_each f all t.
Tactic Notation "value" constr(f) constr(a) "by" tactic3(t) := let all := arguments f (@nil R) in take_for f a all t.
Tactic Notation "with_roots" tactic3(t) := solve [ equal | t; positive ].

(*# roots *)
Lemma root_is x y d : 0 < d -> 0 <= y -> x = y / d ^ 2 -> sqrt x = sqrt y / d.
Proof.
  intros Hd Hy ->. assert (0 < d ^ 2) by (apply pow_lt; exact Hd).
  rewrite sqrt_div_alt by assumption. rewrite sqrt_pow2; lra.
Qed.
(* roots of multiples by squares are multiples of one root *)
Ltac one_root y d := repeat match goal with |- context [sqrt ?a] => tryif constr_eq a y then fail else
  let H := fresh in assert (H : sqrt a = sqrt y / d) by (apply root_is; [positive | solve [apply Rlt_le; positive | lra | positive] | equal]); rewrite H; clear H end.

(*# exponents *)
Lemma exp_power n x : exp x ^ n = exp (INR n * x).
Proof. induction n as [| n IH]; [simpl; rewrite Rmult_0_l, exp_0; reflexivity |]. rewrite S_INR, Rmult_plus_distr_r, Rmult_1_l, exp_plus, <- IH. simpl. ring. Qed.
(* an exponential as a product of whole powers of others *)
Ltac exponents := unfold Rdiv; rewrite ?Rmult_1_l; repeat first [rewrite exp_power | rewrite <- exp_plus | rewrite <- exp_Ropp];
  rewrite ?INR_IZR_INZ; simpl Z.of_nat; f_equal; equal.
Ltac exponential a t := repeat match goal with |- context [exp ?b] =>
  match t with context [exp b] => fail 1 | _ => idtac end; replace (exp b) with t by (replace b with a by equal; exponents) end.

(*# sixth *)
Lemma atan_sixth : atan (sqrt 3 / 3) = PI / 6.
Proof.
  rewrite <- (atan_tan (PI / 6)) by (pose proof PI_RGT_0; lra). f_equal. rewrite tan_PI6.
  assert (Q : sqrt 3 * sqrt 3 = 3) by (apply sqrt_sqrt; lra). assert (sqrt 3 <> 0) by (intro E; rewrite E in Q; lra).
  field [Q]. lra.
Qed.

(*# arcsinh *)
Global Instance UnaryDiff_arcsinh : UnaryDiff arcsinh.
Proof. exists (fun x => / sqrt (x ^ 2 + 1)). intro x. apply is_derive_Reals, derivable_pt_lim_arcsinh. Defined.
Global Typeclasses Opaque arcsinh.

(*# erf *)
Definition erf x := 2 / sqrt PI * RInt (fun t => exp (- t ^ 2)) 0 x.
Lemma derive_erf x : is_derive erf x (2 / sqrt PI * exp (- x ^ 2)).
Proof.
  apply (is_derive_scal (fun x => RInt (fun t => exp (- t ^ 2)) 0 x)).
  assert (C : forall t, continuous (fun t => exp (- t ^ 2)) t).
  { intro t. apply (ex_derive_continuous (V := R_NormedModule)). auto_derive. exact Logic.I. }
  apply (is_derive_RInt (fun t => exp (- t ^ 2)) _ 0); [| apply C].
  exists (mkposreal 1 Rlt_0_1). intros y _.
  apply (RInt_correct (V := R_CompleteNormedModule)), ex_RInt_continuous. intros t _. apply C.
Qed.
Lemma erf_0 : erf 0 = 0.
Proof. unfold erf. rewrite RInt_point. apply Rmult_0_r. Qed.
Global Instance UnaryDiff_erf : UnaryDiff erf.
Proof. exists (fun x => 2 / sqrt PI * exp (- x ^ 2)). exact derive_erf. Defined.
Global Typeclasses Opaque erf.

(*# over *)
(* The integral of F(t)/t from 0, of a function that is like t close to 0; for polylogarithms *)
Definition over (F : R -> R) t := if Req_EM_T t 0 then 1 else F t / t.
Definition mean_of (F : R -> R) x := RInt (over F) 0 x.
Section Over.
Variables (F F' : R -> R) (b : R).
Hypothesis (Hb : 0 < b) (H0 : F 0 = 0) (H1 : F' 0 = 1) (HF : forall x, x < b -> is_derive F x (F' x)).
Lemma continuous_over x : x < b -> continuous (over F) x.
Proof.
  intro Hx. destruct (Req_dec x 0) as [-> | Hn].
  - apply filterlim_locally. intro eps. pose proof (HF 0 Hb) as D. rewrite H1 in D.
    apply is_derive_Reals in D. destruct (D eps (cond_pos eps)) as [d Hd]. exists d. intros t Ht.
    change (Rabs (over F t - over F 0) < eps). change (Rabs (t - 0) < d) in Ht. unfold over.
    destruct (Req_EM_T 0 0) as [_ | E]; [| lra]. destruct (Req_EM_T t 0) as [E | E].
    + rewrite Rminus_eq_0, Rabs_R0. apply cond_pos.
    + rewrite Rminus_0_r in Ht. pose proof (Hd t E Ht) as K. rewrite H0, Rplus_0_l, Rminus_0_r in K. exact K.
  - apply (continuous_ext_loc _ (fun t => F t / t)).
    + assert (P : 0 < Rabs x) by (apply Rabs_pos_lt, Hn). exists (mkposreal _ P). intros t Ht.
      change (Rabs (t - x) < Rabs x) in Ht. unfold over. destruct (Req_EM_T t 0) as [-> | _]; [| reflexivity].
      exfalso. rewrite Rminus_0_l, Rabs_Ropp in Ht. lra.
    + apply (ex_derive_continuous (V := R_NormedModule)). apply (ex_derive_div F (fun t => t)).
      * exists (F' x). apply HF, Hx.
      * apply ex_derive_id.
      * exact Hn.
Qed.
Lemma derive_mean_of x : x < b -> is_derive (mean_of F) x (over F x).
Proof.
  intro Hx. apply (is_derive_RInt _ _ 0); [| apply continuous_over, Hx].
  assert (P : 0 < b - x) by lra. exists (mkposreal _ P). intros y Hy. change (Rabs (y - x) < b - x) in Hy.
  apply (RInt_correct (V := R_CompleteNormedModule)), ex_RInt_continuous. intros t Ht. apply continuous_over.
  apply Rabs_def2 in Hy. destruct Ht as [_ Ht]. revert Ht. unfold Rmax. destruct (Rle_dec 0 y); lra.
Qed.
Lemma mean_of_0 : mean_of F 0 = 0.
Proof. unfold mean_of. apply (RInt_point (V := R_CompleteNormedModule)). Qed.
Lemma over_0 : over F 0 = 1.
Proof. unfold over. destruct (Req_EM_T 0 0); [reflexivity | lra]. Qed.
Lemma over_is x : x <> 0 -> over F x = F x / x.
Proof. intro H. unfold over. destruct (Req_EM_T x 0); [contradiction | reflexivity]. Qed.
End Over.

(*# polylog *)
(* c has these at -1 for PI^2, zeta(3) and PI^4: polylog2 (-1) = - PI^2 / 12, polylog3 (-1) = - 3 / 4 zeta(3),
   polylog4 (-1) = - 7 / 720 PI^4. These three values are not proved here *)
Definition polylog1 x := - ln (1 + - x).
Definition polylog2 := mean_of polylog1.
Definition polylog3 := mean_of polylog2.
Definition polylog4 := mean_of polylog3.
Lemma derive_polylog1 x : x < 1 -> is_derive polylog1 x (/ (1 - x)).
Proof. intro H. unfold polylog1. auto_derive; [lra | field; lra]. Qed.
Lemma polylog1_0 : polylog1 0 = 0.
Proof. unfold polylog1. rewrite Ropp_0, Rplus_0_r, ln_1. lra. Qed.
Lemma derive_polylog2 x : x < 1 -> is_derive polylog2 x (over polylog1 x).
Proof. apply (derive_mean_of _ (fun x => / (1 - x)) 1); [lra | exact polylog1_0 | field | exact derive_polylog1]. Qed.
Lemma derive_polylog3 x : x < 1 -> is_derive polylog3 x (over polylog2 x).
Proof. apply (derive_mean_of _ (over polylog1) 1); [lra | apply mean_of_0 | apply over_0 | exact derive_polylog2]. Qed.
Lemma derive_polylog4 x : x < 1 -> is_derive polylog4 x (over polylog3 x).
Proof. apply (derive_mean_of _ (over polylog2) 1); [lra | apply mean_of_0 | apply over_0 | exact derive_polylog3]. Qed.
Global Instance UnaryDiff_polylog2 : UnaryDiff' polylog2.
Proof.
  exists (fun x => - ln (1 + - x) / x) (fun x => x < 0). intros x H.
  change (- ln (1 + - x)) with (polylog1 x). rewrite <- over_is by lra. apply derive_polylog2. lra.
Defined.
Global Instance UnaryDiff_polylog3 : UnaryDiff' polylog3.
Proof. exists (fun x => polylog2 x / x) (fun x => x < 0). intros x H. rewrite <- over_is by lra. apply derive_polylog3. lra. Defined.
Global Instance UnaryDiff_polylog4 : UnaryDiff' polylog4.
Proof. exists (fun x => polylog3 x / x) (fun x => x < 0). intros x H. rewrite <- over_is by lra. apply derive_polylog4. lra. Defined.
Global Typeclasses Opaque polylog2 polylog3 polylog4.

(*# inverse_tangent *)
(* im(polylog(k, I*y)), the inverse tangent integrals: Ti1 = atan, Ti2(1) is Catalan's constant *)
Definition Ti2 := mean_of atan.
Definition Ti3 := mean_of Ti2.
Definition Ti4 := mean_of Ti3.
Lemma derive_atan x : x < 2 -> is_derive atan x (/ (1 + x ^ 2)).
Proof. intros _. auto_derive; [exact Logic.I | field; nra]. Qed.
Lemma derive_Ti2 x : x < 2 -> is_derive Ti2 x (over atan x).
Proof. apply (derive_mean_of _ (fun x => / (1 + x ^ 2)) 2); [lra | exact atan_0 | field | exact derive_atan]. Qed.
Lemma derive_Ti3 x : x < 2 -> is_derive Ti3 x (over Ti2 x).
Proof. apply (derive_mean_of _ (over atan) 2); [lra | apply mean_of_0 | apply over_0 | exact derive_Ti2]. Qed.
Lemma derive_Ti4 x : x < 2 -> is_derive Ti4 x (over Ti3 x).
Proof. apply (derive_mean_of _ (over Ti2) 2); [lra | apply mean_of_0 | apply over_0 | exact derive_Ti3]. Qed.
Global Instance UnaryDiff_Ti2 : UnaryDiff' Ti2.
Proof. exists (fun x => atan x / x) (fun x => 0 < x < 2). intros x H. rewrite <- over_is by lra. apply derive_Ti2. lra. Defined.
Global Instance UnaryDiff_Ti3 : UnaryDiff' Ti3.
Proof. exists (fun x => Ti2 x / x) (fun x => 0 < x < 2). intros x H. rewrite <- over_is by lra. apply derive_Ti3. lra. Defined.
Global Instance UnaryDiff_Ti4 : UnaryDiff' Ti4.
Proof. exists (fun x => Ti3 x / x) (fun x => 0 < x < 2). intros x H. rewrite <- over_is by lra. apply derive_Ti4. lra. Defined.
Global Typeclasses Opaque Ti2 Ti3 Ti4.

(*# open_ends *)
(* The fundamental theorem for a function that is differentiable between the ends, and continuous there *)
Lemma rise_of_continuous (F f : R -> R) a b : a <= b ->
  (forall x, a < x < b -> is_derive F x (f x)) -> (forall x, a <= x <= b -> continuous F x) ->
  (forall x, continuous f x) -> is_RInt f a b (F b - F a).
Proof.
  intros Hab D CF Cf.
  assert (E : forall x, ex_RInt f a x) by (intro x; apply (ex_RInt_continuous (V := R_CompleteNormedModule)); intros; apply Cf).
  assert (DI : forall x, is_derive (fun x => RInt f a x) x (f x)).
  { intro x. apply (is_derive_RInt f _ a); [| apply Cf]. exists (mkposreal 1 Rlt_0_1). intros y _.
    apply (RInt_correct (V := R_CompleteNormedModule)), E. }
  pose (G := fun x => F x - RInt f a x).
  assert (DG : forall x, a < x < b -> derivable_pt_lim G x 0).
  { intros x Hx. apply is_derive_Reals. replace 0 with (minus (f x) (f x)) by apply (Rminus_eq_0 (f x)).
    apply (is_derive_minus F); [apply D, Hx | apply DI]. }
  assert (pr : forall x, a < x < b -> derivable_pt G x) by (intros x Hx; exists 0; apply DG, Hx).
  assert (CG : forall x, a <= x <= b -> continuity_pt G x).
  { intros x Hx. apply continuity_pt_filterlim. apply (continuous_minus F (fun x => RInt f a x)); [apply CF, Hx |].
    apply (ex_derive_continuous (V := R_NormedModule)). exists (f x). apply DI. }
  assert (K : G b = G a).
  { apply (null_derivative_loc G a b pr CG); [| lra]. intros x P.
    apply derive_pt_eq_0, DG, P. }
  unfold G in K. rewrite (RInt_point (V := R_CompleteNormedModule)) in K. change zero with 0 in K.
  replace (F b - F a) with (RInt f a b) by lra. apply (RInt_correct (V := R_CompleteNormedModule)), E.
Qed.
Lemma rise_between (F f : R -> R) a b : a <= b ->
  (forall x, a < x < b -> is_derive F x (f x)) -> (forall x, a <= x <= b -> continuous F x) ->
  (forall x, a <= x <= b -> continuous f x) -> is_RInt f a b (F b - F a).
Proof.
  intros Hab D CF Cf. destruct (C0_extension_le f a b Cf) as [h [Ch Eh]].
  apply (is_RInt_ext h).
  - rewrite Rmin_left, Rmax_right by exact Hab. intros x Hx. apply Eh. lra.
  - apply rise_of_continuous; [exact Hab | | exact CF | exact Ch].
    intros x Hx. rewrite Eh by lra. apply D, Hx.
Qed.

(*# powers *)
(* x^p for p > 0, which vanishes at x = 0 *)
Definition power p x := if Rle_dec x 0 then 0 else exp (p * ln x).
Lemma power_is p x : 0 < x -> power p x = exp (p * ln x).
Proof. intro H. unfold power. destruct (Rle_dec x 0); [lra | reflexivity]. Qed.
Lemma power_0 p : power p 0 = 0.
Proof. unfold power. destruct (Rle_dec 0 0); [reflexivity | lra]. Qed.
Lemma near x t : 0 < x -> Rabs (t - x) < x -> 0 < t.
Proof. intros H K. apply Rabs_def2 in K. lra. Qed.
Lemma continuous_power p x : 0 < p -> continuous (power p) x.
Proof.
  intro Hp. destruct (Rtotal_order x 0) as [H | [-> | H]].
  - apply (continuous_ext_loc _ (fun _ => 0)); [| apply continuous_const].
    assert (P : 0 < - x) by lra. exists (mkposreal _ P). intros t Ht. change (Rabs (t - x) < - x) in Ht.
    apply Rabs_def2 in Ht. unfold power. destruct (Rle_dec t 0); [reflexivity | lra].
  - apply filterlim_locally. intro eps. exists (mkposreal _ (exp_pos (ln eps / p))). intros t Ht.
    change (Rabs (t - 0) < exp (ln eps / p)) in Ht. change (Rabs (power p t - power p 0) < eps).
    rewrite power_0, Rminus_0_r. rewrite Rminus_0_r in Ht. destruct (Rle_dec t 0) as [L | L].
    + unfold power. destruct (Rle_dec t 0); [| contradiction]. rewrite Rabs_R0. apply cond_pos.
    + assert (0 < t) by lra. rewrite power_is by assumption. rewrite Rabs_pos_eq by (apply Rlt_le, exp_pos).
      rewrite Rabs_pos_eq in Ht by lra. rewrite <- (exp_ln eps) by apply cond_pos. apply exp_increasing.
      assert (ln t < ln eps / p) by (rewrite <- (ln_exp (ln eps / p)); apply ln_increasing; assumption).
      replace (ln eps) with (p * (ln eps / p)) by (field; lra). apply Rmult_lt_compat_l; assumption.
  - apply (continuous_ext_loc _ (fun x => exp (p * ln x))).
    + exists (mkposreal _ H). intros t Ht. symmetry. apply power_is, (near x); assumption.
    + apply (ex_derive_continuous (V := R_NormedModule)). auto_derive. exact H.
Qed.
Lemma derive_power p x : 0 < x -> is_derive (power p) x (p * power p x / x).
Proof.
  intro H. apply (is_derive_ext_loc (fun x => exp (p * ln x))).
  - exists (mkposreal _ H). intros t Ht. symmetry. apply power_is, (near x); assumption.
  - rewrite power_is by exact H. auto_derive; [exact H | field; lra].
Qed.
Global Instance UnaryDiff_power p : UnaryDiff' (power p).
Proof. exists (fun x => p * power p x / x) (fun x => 0 < x). exact (derive_power p). Defined.
Global Typeclasses Opaque power.

(*# products *)
Ltac power_by_exp := idtac.
Ltac power_by_exp ::= rewrite ?power_is by positive.  (*? powers *)
Lemma exp_of_product p a b : 0 < a -> 0 < b -> exp (p * ln (a * b)) = exp (p * ln a) * exp (p * ln b).
Proof. intros. rewrite ln_mult, Rmult_plus_distr_l by assumption. apply exp_plus. Qed.
Lemma exp_of_quotient p a b : 0 < a -> 0 < b -> exp (p * ln (a * / b)) = exp (p * ln a) * exp (- p * ln b).
Proof. intros. rewrite exp_of_product, ln_Rinv by (assumption || apply Rinv_0_lt_compat; assumption). f_equal. f_equal. ring. Qed.
Ltac split_powers := power_by_exp; unfold Rpower, Rdiv; rewrite ?exp_of_quotient by positive; rewrite ?exp_of_product by positive.

(*# incomplete_gamma *)
(* The integral of t^(s-1) exp(-t) from 0 to z, over u = t^s; and that for s = k/p and z = y^p *)
Definition gamma_from_0 s z := / s * RInt (fun u => exp (- power (/ s) u)) 0 (power s z).
Definition lower_gamma (k : nat) p y := gamma_from_0 (INR k / p) (power p y).
Lemma continuous_exp_power q u : 0 < q -> continuous (fun u => exp (- power q u)) u.
Proof.
  intro H. apply (continuous_comp (fun u => - power q u) exp); [apply (continuous_opp (power q)), continuous_power, H |].
  apply (ex_derive_continuous (V := R_NormedModule)). auto_derive. exact Logic.I.
Qed.
Lemma derive_RInt_exp_power q u : 0 < q -> is_derive (fun u => RInt (fun u => exp (- power q u)) 0 u) u (exp (- power q u)).
Proof.
  intro H. apply (is_derive_RInt (fun u => exp (- power q u)) _ 0); [| apply continuous_exp_power, H].
  exists (mkposreal 1 Rlt_0_1). intros y _. apply (RInt_correct (V := R_CompleteNormedModule)), ex_RInt_continuous.
  intros t _. apply continuous_exp_power, H.
Qed.
Lemma power_power p q x : power p (power q x) = power (p * q) x.
Proof.
  unfold power at 2 3. destruct (Rle_dec x 0); [apply power_0 |].
  rewrite power_is by apply exp_pos. rewrite ln_exp. f_equal. ring.
Qed.
Lemma power_nat (k : nat) x : 0 < x -> power (INR k) x = x ^ k.
Proof. intro H. rewrite power_is by exact H. rewrite <- Rpower_pow by exact H. reflexivity. Qed.
(* it is what it is called: its derivative is z^(s-1) exp(-z), and it vanishes at 0 *)
Lemma derive_gamma_from_0 s z : 0 < s -> 0 < z -> is_derive (gamma_from_0 s) z (power s z / z * exp (- z)).
Proof.
  intros Hs Hz. assert (0 < / s) by (apply Rinv_0_lt_compat, Hs). unfold gamma_from_0.
  replace (power s z / z * exp (- z)) with (/ s * (s * power s z / z * exp (- power (/ s) (power s z)))).
  - apply (is_derive_scal (fun z => RInt (fun u => exp (- power (/ s) u)) 0 (power s z))).
    apply (is_derive_comp (fun u => RInt (fun u => exp (- power (/ s) u)) 0 u) (power s)).
    + apply derive_RInt_exp_power. assumption.
    + apply derive_power, Hz.
  - rewrite power_power. replace (/ s * s) with 1 by (field; lra).
    replace (power 1 z) with z by (rewrite power_is, Rmult_1_l, exp_ln by exact Hz; reflexivity). field. lra.
Qed.
Lemma gamma_from_0_0 s : gamma_from_0 s 0 = 0.
Proof. unfold gamma_from_0. rewrite power_0, (RInt_point (V := R_CompleteNormedModule)). apply Rmult_0_r. Qed.
Lemma lower_gamma_0 k p : lower_gamma k p 0 = 0.
Proof. unfold lower_gamma. rewrite power_0. apply gamma_from_0_0. Qed.
Lemma continuous_lower_gamma k p y : 0 < p -> continuous (lower_gamma (S k) p) y.
Proof.
  intro Hp. pose proof (lt_0_INR (S k) (Nat.lt_0_succ k)) as Hk.
  assert (Hs : 0 < INR (S k) / p) by (apply Rdiv_lt_0_compat; assumption). assert (0 < / (INR (S k) / p)) by (apply Rinv_0_lt_compat, Hs).
  apply (continuous_comp (power p) (gamma_from_0 (INR (S k) / p))); [apply continuous_power, Hp |]. unfold gamma_from_0.
  apply (continuous_scal_r (/ (INR (S k) / p)) (fun z => RInt (fun u => exp (- power (/ (INR (S k) / p)) u)) 0 (power (INR (S k) / p) z))).
  apply (continuous_comp (power (INR (S k) / p)) (fun u => RInt (fun u => exp (- power (/ (INR (S k) / p)) u)) 0 u)); [apply continuous_power, Hs |].
  apply (ex_derive_continuous (V := R_NormedModule)). eexists. apply derive_RInt_exp_power. assumption.
Qed.
Lemma derive_lower_gamma k p y : 0 < p -> 0 < y -> is_derive (lower_gamma (S k) p) y (p * y ^ k * exp (- power p y)).
Proof.
  intros Hp Hy. pose proof (lt_0_INR (S k) (Nat.lt_0_succ k)) as Hk.
  assert (Hs : 0 < INR (S k) / p) by (apply Rdiv_lt_0_compat; assumption).
  assert (Hz : 0 < power p y) by (rewrite power_is by exact Hy; apply exp_pos).
  replace (p * y ^ k * exp (- power p y)) with (p * power p y / y * (power (INR (S k) / p) (power p y) / power p y * exp (- power p y))).
  - apply (is_derive_comp (gamma_from_0 (INR (S k) / p)) (power p)).
    + apply derive_gamma_from_0; assumption.
    + apply derive_power, Hy.
  - rewrite power_power. replace (INR (S k) / p * p) with (INR (S k)) by (field; lra).
    rewrite power_nat by exact Hy. simpl pow. field. lra.
Qed.
Global Instance UnaryDiff_lower_gamma k p : UnaryDiff' (lower_gamma (S k) p).
Proof. exists (fun y => p * y ^ k * exp (- power p y)) (fun y => 0 < p /\ 0 < y). intros y [Hp Hy]. apply derive_lower_gamma; assumption. Defined.
Global Typeclasses Opaque lower_gamma.

(*# continuous *)
(* a function with roots or powers that is continuous where their base vanishes *)
Ltac continuous := unfold Rdiv, Rminus; repeat first [ solve [apply continuous_const] | solve [apply continuous_id] | match goal with
  | |- continuous (fun x => @?f x + @?g x) ?a => apply (continuous_plus f g a)
  | |- continuous (fun x => @?f x * @?g x) ?a => apply (continuous_mult f g a)
  | |- continuous (fun x => - @?f x) ?a => apply (continuous_opp f a)
  | |- continuous (fun x => (@?f x) ^ ?n) ?a => apply (continuous_comp f (fun y => y ^ n) a); [| apply (ex_derive_continuous (V := R_NormedModule)); auto_derive; exact Logic.I]
  | |- continuous (fun x => exp (@?f x)) ?a => apply (continuous_comp f exp a); [| apply (ex_derive_continuous (V := R_NormedModule)); auto_derive; exact Logic.I]
  | |- continuous (fun x => sqrt (@?f x)) ?a => apply (continuous_comp f sqrt a); [| apply continuous_sqrt]
  | |- continuous (fun x => power ?p (@?f x)) ?a => apply (continuous_comp f (power p) a); [| apply continuous_power; positive]  (*? powers *)
  | |- continuous (fun x => lower_gamma ?k ?p (@?f x)) ?a => apply (continuous_comp f (lower_gamma k p) a); [| apply continuous_lower_gamma; positive]  (*? incomplete_gamma *)
  end ].

(*# bounds *)
Lemma Rmin_scaled k a b p q : 0 < k -> a = k * p -> b = k * q -> Rmin a b = k * Rmin p q.
Proof. intros Hk -> ->. unfold Rmin. repeat destruct Rle_dec; try reflexivity; exfalso; nra. Qed.
Lemma Rmax_scaled k a b p q : 0 < k -> a = k * p -> b = k * q -> Rmax a b = k * Rmax p q.
Proof. intros Hk -> ->. unfold Rmax. repeat destruct Rle_dec; try reflexivity; exfalso; nra. Qed.
Ltac scaled := solve [apply Rmin_scaled; [positive | scaled | scaled] | apply Rmax_scaled; [positive | scaled | scaled]
  | field; positive].

(*# sums *)
Lemma integral_plus f g a b I J : is_RInt f a b I -> is_RInt g a b J -> is_RInt (fun v => f v + g v) a b (I + J).
Proof. exact (is_RInt_plus f g a b I J). Qed.
Lemma integral_times k f a b I : is_RInt f a b I -> is_RInt (fun v => k * f v) a b (k * I).
Proof. exact (is_RInt_scal f a b k I). Qed.

Lemma integral_chain f a b d I J : is_RInt f a b I -> is_RInt f b d J -> is_RInt f a d (I + J).
Proof. exact (is_RInt_Chasles (V := R_NormedModule) f a b d I J). Qed.

(*# angle *)
(* Over the angle t of v = V (1 - cos t), 0 <= t <= PI *)
Lemma rise_of (F f : R -> R) a b : (forall t, is_derive F t (f t)) -> (forall t, continuous f t) -> is_RInt f a b (F b - F a).
Proof. intros D C. exact (is_RInt_derive F f a b (fun t _ => D t) (fun t _ => C t)). Qed.
Lemma sine_squared t : sin t * sin t = 1 - cos t * cos t.
Proof. pose proof (sin2_cos2 t) as E. unfold Rsqr in E. lra. Qed.

(*# poisson *)
(* Poisson's kernel (1 - rho^2)/(1 + rho^2 - 2 rho cos a), an antiderivative of it, and of its conjugate *)
Lemma less_of_squares a b : 0 < b -> a ^ 2 < b ^ 2 -> a < b.
Proof. intros. destruct (Rlt_le_dec a b) as [L | L]; [exact L | exfalso; nra]. Qed.
Section Poisson.
Variable rho : R.
Hypothesis (Hrho : 0 < rho < 1).
Definition circle a := 1 + rho ^ 2 - 2 * rho * cos a.
Definition turn a := a + 2 * atan (rho * sin a / (1 - rho * cos a)).
Lemma circle_positive a : 0 < circle a.
Proof. unfold circle. pose proof (COS_bound a). nra. Qed.
Lemma derive_turn a : is_derive turn a ((1 - rho ^ 2) / circle a).
Proof.
  pose proof (COS_bound a) as B. pose proof (circle_positive a) as P. assert (0 < 1 - rho * cos a) by nra.
  pose proof (sine_squared a) as Q.
  unfold turn. auto_derive; [lra |]. unfold circle in *. field [Q].
  replace (1 + rho ^ 2 - 2 * rho * cos a) with ((1 - rho * cos a) ^ 2 + (rho * sin a) ^ 2) in P by ring [Q].
  repeat split; try lra. nra.
Qed.
Lemma derive_log_circle a : is_derive (fun a => ln (circle a)) a (2 * rho * sin a / circle a).
Proof. pose proof (circle_positive a) as P. unfold circle in *. auto_derive; [exact P | field; lra]. Qed.
Lemma turn_odd a : turn (- a) = - turn a.
Proof.
  unfold turn. rewrite sin_neg, cos_neg, Ropp_mult_distr_r_reverse. unfold Rdiv.
  rewrite Ropp_mult_distr_l_reverse, atan_opp. ring.
Qed.
Lemma turn_beside_half a : turn (PI + - a) = 2 * PI - turn (PI + a).
Proof.
  unfold turn. replace (PI + - a) with (- (- PI + a)) by ring.
  rewrite sin_neg, cos_neg. replace (- PI + a) with (PI + a - 2 * PI) by ring.
  rewrite sin_minus, cos_minus, sin_2PI, cos_2PI, !Rmult_1_r, !Rmult_0_r, Rminus_0_r, Rplus_0_r.
  replace (rho * - sin (PI + a) / (1 - rho * cos (PI + a))) with (- (rho * sin (PI + a) / (1 - rho * cos (PI + a)))) by (unfold Rdiv; ring).
  rewrite atan_opp. ring.
Qed.
Lemma continuous_kernel a : continuous (fun a => (1 - rho ^ 2) / circle a) a.
Proof.
  pose proof (circle_positive a) as P. unfold circle in *.
  apply (ex_derive_continuous (V := R_NormedModule)). auto_derive. lra.
Qed.
Lemma continuous_conjugate a : continuous (fun a => 2 * rho * sin a / circle a) a.
Proof.
  pose proof (circle_positive a) as P. unfold circle in *.
  apply (ex_derive_continuous (V := R_NormedModule)). auto_derive. lra.
Qed.
End Poisson.
Lemma derive_shifted (F f : R -> R) b a : is_derive F (a + b) (f (a + b)) -> is_derive (fun t => F (t + b)) a (f (a + b)).
Proof.
  intro D. replace (f (a + b)) with (1 * f (a + b)) by ring.
  apply (is_derive_comp F (fun t => t + b)); [exact D | auto_derive; [exact Logic.I | reflexivity]].
Qed.
Lemma continuous_shifted (f : R -> R) b a : (forall a, continuous f a) -> continuous (fun t => f (t + b)) a.
Proof.
  intro C. apply (continuous_comp (fun t => t + b) f); [| apply C].
  apply (ex_derive_continuous (V := R_NormedModule)). auto_derive. exact Logic.I.
Qed.
(* the integral of a function of t + b *)
Lemma rise_shifted (F f : R -> R) b : (forall a, is_derive F a (f a)) -> (forall a, continuous f a) ->
  is_RInt (fun t => f (t + b)) 0 PI (F (PI + b) - F (0 + b)).
Proof. intros D C. apply (rise_of (fun t => F (t + b))); intro t; [apply derive_shifted, D | apply continuous_shifted, C]. Qed.

(*# linear_pole *)
(* 1/(v + w), w > 0; S is the root of w (w + 2 V) *)
Lemma linear_pole V w S : 0 < V -> 0 < w -> 0 < S -> S ^ 2 = w * (w + 2 * V) ->
  is_RInt (fun t => / (V * (1 - cos t) + w)) 0 PI (PI / S).
Proof.
  intros HV Hw HS E. pose (rho := (w + V - S) / V).
  assert (S < w + V) by (apply less_of_squares; [lra | rewrite E; nra]).
  assert (w < S) by (apply less_of_squares; [lra | rewrite E; nra]).
  assert (Hrho : 0 < rho < 1) by (unfold rho; split; [apply Rdiv_lt_0_compat; lra | apply Rlt_div_l; lra]).
  replace (PI / S) with (/ S * (turn rho PI - turn rho 0)).
  2: { unfold turn. rewrite sin_PI, sin_0, !Rmult_0_r. unfold Rdiv. rewrite !Rmult_0_l, atan_0. ring. }
  apply (is_RInt_ext (fun t => / S * ((1 - rho ^ 2) / circle rho t))).
  - intros t _. pose proof (COS_bound t). pose proof (circle_positive rho Hrho t). assert (0 < V * (1 - cos t) + w) by nra.
    change_to_reals.
    assert (C : circle rho t = 2 * rho / V * (V * (1 - cos t) + w)) by (unfold circle, rho; field [E]; lra).
    assert (D : 1 - rho ^ 2 = 2 * rho / V * S) by (unfold rho; field [E]; lra).
    rewrite C, D. field. lra.
  - apply integral_times, (rise_of (turn rho)); intro t; [apply derive_turn, Hrho | apply continuous_kernel, Hrho].
Qed.

(*# quadratic_pole *)
(* 1/q and v/q, q = v^2 + b v + c with complex zeros; m and X are the roots of its values at 0 and 2 V *)
Lemma quadratic_positive b c d y : 0 < d -> 4 * c = b ^ 2 + d -> 0 < y ^ 2 + b * y + c.
Proof. intros. pose proof (pow2_ge_0 (2 * y + b)). lra. Qed.
Section Quadratic.
Variables V b c d m X Z : R.
Hypothesis (HV : 0 < V) (Hm : 0 < m) (HX : 0 < X) (HZ : 0 < Z) (Hd : 0 < d) (Ed : 4 * c = b ^ 2 + d).
Hypothesis (Em : m ^ 2 = c) (EX : X ^ 2 = c + 2 * b * V + 4 * V ^ 2) (EZ : Z ^ 2 = 2 * (c + b * V + m * X)).
Let rho := (m + X - Z) / (2 * V).
Let C := (X - m) / (2 * V).
Let e := acos C.
Let v t := V * (1 - cos t).
Let q t := v t ^ 2 + b * v t + c.
Lemma b_by_roots : b = (X ^ 2 - m ^ 2) / (2 * V) - 2 * V.
Proof. rewrite EX, Em. field. lra. Qed.
Lemma Z_by_roots : Z ^ 2 = (m + X) ^ 2 - 4 * V ^ 2.
Proof. rewrite EZ. replace ((m + X) ^ 2) with (m ^ 2 + 2 * m * X + X ^ 2) by ring. rewrite EX, Em. ring. Qed.
Lemma q_positive t : 0 < q t.
Proof. apply (quadratic_positive b c d); assumption. Qed.
Lemma X_between : - (2 * V) < X - m < 2 * V /\ 2 * V < X + m.
Proof.
  assert (b < 2 * m) by (apply less_of_squares; [lra | nra]). assert (- b < 2 * m) by (apply less_of_squares; [lra | nra]).
  assert (X < m + 2 * V) by (apply less_of_squares; [lra | rewrite EX; nra]).
  assert (2 * V - m < X) by (apply less_of_squares; [lra | rewrite EX; nra]).
  assert (m - 2 * V < X) by (apply less_of_squares; [lra | rewrite EX; nra]). lra.
Qed.
Lemma rho_inside : 0 < rho < 1.
Proof.
  pose proof Z_by_roots. destruct X_between as [_ ?].
  assert (Z < m + X) by (apply less_of_squares; nra). assert (m + X - 2 * V < Z) by (apply less_of_squares; nra).
  unfold rho. split; [apply Rdiv_lt_0_compat; lra | apply Rlt_div_l; lra].
Qed.
Lemma C_inside : -1 < C < 1.
Proof. destruct X_between as [? _]. unfold C. split; [apply Rlt_div_r | apply Rlt_div_l]; lra. Qed.
Lemma cosine_is : cos e = C.
Proof. pose proof C_inside. apply cos_acos. lra. Qed.
Lemma sine_positive : 0 < sin e.
Proof. pose proof C_inside. unfold e. rewrite sin_acos by lra. apply sqrt_lt_R0. unfold Rsqr. nra. Qed.
Lemma product_of_circles t : circle rho (t + - e) * circle rho (t + e) = (2 * rho / V) ^ 2 * q t.
Proof.
  assert (Q : sin e * sin e = 1 - C * C) by (rewrite <- cosine_is; apply sine_squared).
  pose proof (sine_squared t) as Q'.
  pose proof Z_by_roots as Q''. unfold circle. rewrite !cos_plus, cos_neg, sin_neg, cosine_is.
  transitivity ((1 + rho ^ 2 - 2 * rho * cos t * C) ^ 2 - 4 * rho ^ 2 * (1 - cos t * cos t) * (1 - C * C)); [rewrite <- Q, <- Q'; ring |].
  unfold q, v. rewrite <- Em, b_by_roots. unfold C, rho. field [Q'']. lra.
Qed.
Lemma sum_of_kernels : is_RInt (fun t => (m + X - (X - m) * cos t) / q t) 0 PI (4 * PI / Z).
Proof.
  pose proof rho_inside as R.
  replace (4 * PI / Z) with (2 / Z * ((turn rho (PI + - e) - turn rho (0 + - e)) + (turn rho (PI + e) - turn rho (0 + e)))).
  2: { replace (0 + - e) with (- e) by ring. rewrite Rplus_0_l, (turn_odd rho e), (turn_beside_half rho e). field. lra. }
  apply (is_RInt_ext (fun t => 2 / Z * ((1 - rho ^ 2) / circle rho (t + - e) + (1 - rho ^ 2) / circle rho (t + e)))).
  - intros t _. pose proof (circle_positive rho R (t + - e)). pose proof (circle_positive rho R (t + e)). pose proof (q_positive t).
    change_to_reals.
    transitivity (2 / Z * ((1 - rho ^ 2) * (circle rho (t + - e) + circle rho (t + e)) / (circle rho (t + - e) * circle rho (t + e)))); [field; lra |].
    rewrite product_of_circles. replace (circle rho (t + - e) + circle rho (t + e)) with (2 * rho / V * (m + X - (X - m) * cos t)).
    + replace (1 - rho ^ 2) with (rho / V * Z) by (unfold rho; field [Z_by_roots]; lra). field. repeat split; lra.
    + unfold circle. rewrite !cos_plus, cos_neg, sin_neg, cosine_is. unfold C, rho. field [Z_by_roots]. lra.
  - apply integral_times, integral_plus; apply (rise_shifted (turn rho) (fun a => (1 - rho ^ 2) / circle rho a)); intro a;
      [apply derive_turn, R | apply continuous_kernel, R | apply derive_turn, R | apply continuous_kernel, R].
Qed.
Lemma difference_of_kernels : is_RInt (fun t => ((m + X) * cos t - (X - m)) / q t) 0 PI 0.
Proof.
  pose proof rho_inside as R. pose proof sine_positive as P.
  pose (F a := ln (circle rho a)). pose (f a := 2 * rho * sin a / circle rho a).
  assert (J : / (sin e * V) * ((F (PI + e) - F (0 + e)) + -1 * (F (PI + - e) - F (0 + - e))) = 0).
  { unfold F, circle. assert (E : forall s, sin s = 0 -> cos (s + - e) = cos (s + e)) by (intros s Es; rewrite !cos_plus, cos_neg, Es; ring).
    rewrite (E PI sin_PI), (E 0 sin_0). ring. }
  rewrite <- J at 2.
  apply (is_RInt_ext (fun t => / (sin e * V) * (f (t + e) + -1 * f (t + - e)))).
  - intros t _. pose proof (circle_positive rho R (t + - e)). pose proof (circle_positive rho R (t + e)). pose proof (q_positive t).
    pose proof (sine_squared t) as Q.
    change_to_reals.
    transitivity (/ (sin e * V) * (2 * rho * (sin (t + e) * circle rho (t + - e) - sin (t + - e) * circle rho (t + e)) / (circle rho (t + - e) * circle rho (t + e)))); [unfold f; field; repeat split; lra |].
    rewrite product_of_circles. replace (sin (t + e) * circle rho (t + - e) - sin (t + - e) * circle rho (t + e)) with (2 * sin e * rho / V * ((m + X) * cos t - (X - m))).
    + field. repeat split; lra.
    + unfold circle. rewrite !cos_plus, !sin_plus, cos_neg, sin_neg, cosine_is. unfold C, rho. field [Z_by_roots Q]. lra.
  - apply integral_times, integral_plus; [| apply integral_times]; apply (rise_shifted F f); intro a;
      [apply derive_log_circle, R | apply continuous_conjugate, R | apply derive_log_circle, R | apply continuous_conjugate, R].
Qed.
Lemma quadratic_pole : is_RInt (fun t => / q t) 0 PI (PI * (m + X) / (Z * m * X)).
Proof.
  pose proof X_between. replace (PI * (m + X) / (Z * m * X)) with ((m + X) / (4 * m * X) * (4 * PI / Z) + (X - m) / (4 * m * X) * 0) by (field; lra).
  apply (is_RInt_ext (fun t => (m + X) / (4 * m * X) * ((m + X - (X - m) * cos t) / q t) + (X - m) / (4 * m * X) * (((m + X) * cos t - (X - m)) / q t))).
  - intros t _. pose proof (q_positive t). change_to_reals. field. repeat split; lra.
  - apply integral_plus; apply integral_times; [exact sum_of_kernels | exact difference_of_kernels].
Qed.
Lemma quadratic_pole_at_speed : is_RInt (fun t => v t / q t) 0 PI (2 * PI * V / (Z * X)).
Proof.
  pose proof X_between. replace (2 * PI * V / (Z * X)) with (V / (2 * X) * (4 * PI / Z) + - V / (2 * X) * 0) by (field; lra).
  apply (is_RInt_ext (fun t => V / (2 * X) * ((m + X - (X - m) * cos t) / q t) + - V / (2 * X) * (((m + X) * cos t - (X - m)) / q t))).
  - intros t _. pose proof (q_positive t). change_to_reals. unfold v. field. repeat split; lra.
  - apply integral_plus; apply integral_times; [exact sum_of_kernels | exact difference_of_kernels].
Qed.
End Quadratic.

(*# scale *)
(* The integral of a profile over speeds in units of a scale, and that of a term of a law *)
Lemma at_scale (g : R -> R) (K : R -> R -> R) s V I : 0 < s -> (forall v, K (V / s) (v / s) = s ^ 2 * K V v) ->
  is_RInt (fun u => g u * K (V / s) u) 0 (2 * (V / s)) I -> is_RInt (fun v => g (v / s) * K V v) 0 (2 * V) (I / s).
Proof.
  intros Hs HK HI.
  assert (H : is_RInt (fun u => g u * K (V / s) u) (/ s * 0 + 0) (/ s * (2 * V) + 0) I).
  { replace (/ s * 0 + 0) with 0 by ring. replace (/ s * (2 * V) + 0) with (2 * (V / s)) by (field; lra). exact HI. }
  apply is_RInt_comp_lin in H. apply (is_RInt_scal _ _ _ (/ s)) in H.
  replace (I / s) with (scal (/ s) I) by (apply Rmult_comm). revert H. apply is_RInt_ext. intros v _.
  change (/ s * (/ s * (g (/ s * v + 0) * K (V / s) (/ s * v + 0))) = g (v / s) * K V v).
  replace (/ s * v + 0) with (v / s) by (field; lra). rewrite HK. field. lra.
Qed.
Lemma less_at_scale s v p q : 0 < s -> p = s * q -> (v / s < q <-> v < p).
Proof.
  intros Hs ->. split; intro H.
  - apply (Rmult_lt_compat_l s) in H; [| exact Hs]. replace (s * (v / s)) with v in H by (field; lra). exact H.
  - apply (Rmult_lt_reg_l s); [exact Hs |]. replace (s * (v / s)) with v by (field; lra). exact H.
Qed.

(*# nearby *)
Lemma below_nearby x p : x < p -> locally x (fun y => y < p).
Proof. intro H. apply (locally_interval _ x m_infty (Finite p)); simpl; [exact Logic.I | exact H | intros; assumption]. Qed.
Lemma above_nearby x p : p < x -> locally x (fun y => p < y).
Proof. intro H. apply (locally_interval _ x (Finite p) p_infty); simpl; [exact H | exact Logic.I | intros; assumption]. Qed.
Lemma nearby x (P Q : R -> Prop) : locally x P -> locally x (fun y => P y -> Q y) -> locally x Q.
Proof. intros HP HQ. generalize (filter_and _ _ HP HQ). apply filter_imp. tauto. Qed.
