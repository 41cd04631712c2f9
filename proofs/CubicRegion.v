(** The cubic observer with its gains as stored, from an ellipsoid of errors: the theorem [cubic-observer] of
    certificates with a level.

    A stored N has [P N = R - C'S] with a small R. Where [F'P + PF <= - q I], [S + S' >= mu I], [theta <= t I],
    [|R y| <= rho |y|] and [|C e| <= kappa |e|], [V = e'Pe] has the derivative
    [V' <= - q |e|^2 + t |y|^3 max(0, 2 rho |e| - mu |y|)], [y = C e], and the last term is at most
    [27 t rho^4 |e|^4 / (16 mu^3)] and at most [2 t rho kappa^3 |e|^4]. While V is below a level at which this is less
    than [q |e|^2], V falls, so that it stays there. *)

From Coq Require Import Reals QArith Qreals ZArith List Lra Lia.
From Luenberger Require Import Vectors Definite Inequalities Decay LinearObserver CubicObserver.
Import ListNotations.
Local Open Scope R_scope.
Local Open Scope lazy_bool_scope.

(** ** A function that falls where it is below a level *)

(** Then it stays below what it is in the beginning. *)
Lemma stays_below T f d level :
  right_continuous_at_0 f -> (forall t, 0 < t < T -> derivable_pt_lim f t (d t)) ->
  (forall t, 0 < t < T -> f t < level -> d t <= 0) -> f 0 < level ->
  forall t, 0 <= t -> t < T -> f t <= f 0.
Proof.
  intros Start D Falls Below t1 H0 H1. apply Rnot_lt_le. intros Above.
  destruct (Req_dec t1 0) as [->|Nonzero]; [lra|].
  (* The last time at which f is not above f 0. *)
  destruct (completeness (fun s => 0 <= s <= t1 /\ f s <= f 0)) as (tau & Upper & Least).
  { exists t1. intros s [S _]. lra. }
  { exists 0. split; lra. }
  assert (Tau : 0 <= tau <= t1).
  { split; [apply Upper; split; lra|apply Least; intros s [S _]; lra]. }
  assert (Beyond : forall s, tau < s <= t1 -> f 0 < f s).
  { intros s S. apply Rnot_le_lt. intros N. assert (s <= tau) by (apply Upper; split; lra). lra. }
  assert (Continuous : 0 < tau -> forall eps, 0 < eps ->
    exists delta, 0 < delta /\ forall s, Rabs (s - tau) < delta -> Rabs (f s - f tau) < eps).
  { intros P eps He. assert (C : continuity_pt f tau).
    { apply derivable_continuous_pt. exists (d tau). apply D. split; [exact P|].
      destruct (Req_dec tau t1) as [E|E]; lra. }
    destruct (C eps He) as (delta & Hd & K). exists delta. split; [exact Hd|]. intros s Hs.
    destruct (Req_dec s tau) as [->|E]; [rewrite Rminus_diag_eq, Rabs_R0; trivial|].
    apply (K s). split; [split; [exact I|congruence]|]. exact Hs. }
  assert (At : f tau <= f 0).
  { destruct (Req_dec tau 0) as [->|E]; [lra|]. apply Rnot_lt_le. intros N.
    destruct (Continuous ltac:(lra) (f tau - f 0)) as (delta & Hd & K); [lra|].
    assert (tau <= tau - delta); [|lra]. apply Least. intros s [S F]. apply Rnot_lt_le. intros M.
    assert (s <= tau) by (apply Upper; split; lra).
    assert (B : Rabs (f s - f tau) < f tau - f 0) by (apply K; apply Rabs_def1; lra). apply Rabs_def2 in B. lra. }
  assert (Before : tau < t1) by (destruct (Req_dec tau t1) as [E|E]; [rewrite E in At|]; lra).
  (* From then on it is below the level for a while, and falls. *)
  assert (Near : exists delta, 0 < delta /\ forall s, tau <= s < tau + delta -> f s < level).
  { destruct (Req_dec tau 0) as [->|E].
    - destruct (Start (level - f 0)) as (delta & Hd & K); [lra|]. exists delta. split; [exact Hd|]. intros s S.
      assert (B : Rabs (f s - f 0) < level - f 0) by (apply K; lra). apply Rabs_def2 in B. lra.
    - destruct (Continuous ltac:(lra) (level - f 0)) as (delta & Hd & K); [lra|]. exists delta. split; [exact Hd|].
      intros s S. assert (B : Rabs (f s - f tau) < level - f 0) by (apply K; apply Rabs_def1; lra).
      apply Rabs_def2 in B. lra. }
  destruct Near as (delta & Hd & Near).
  set (width := Rmin delta (t1 - tau)).
  assert (0 < width) by (apply Rmin_glb_lt; lra).
  assert (width <= delta) by apply Rmin_l. assert (width <= t1 - tau) by apply Rmin_r.
  assert (Fall : f (tau + width / 2) <= f (tau + 0)).
  { apply (decreasing width (fun s => f (tau + s)) (fun s => d (tau + s))); try lra.
    - destruct (Req_dec tau 0) as [Z|Z].
      + intros eps He. destruct (Start eps He) as (x & Hx & K). exists x. split; [exact Hx|]. intros s S.
        rewrite Z, Rplus_0_l, Rplus_0_r. apply K, S.
      + intros eps He. destruct (Continuous ltac:(lra) eps He) as (x & Hx & K). exists x. split; [exact Hx|].
        intros s S. rewrite Rplus_0_r. apply K. replace (tau + s - tau) with s by ring. apply Rabs_def1; lra.
    - intros s S. replace (d (tau + s)) with (d (tau + s) * 1) by ring.
      apply (derivable_pt_lim_comp (fun s => tau + s) f); [|apply D; lra].
      replace 1 with (0 + 1) by ring. apply derivable_pt_lim_plus; [apply derivable_pt_lim_const|apply
        derivable_pt_lim_id].
    - intros s S. apply Falls; [lra|]. apply Near. lra. }
  rewrite Rplus_0_r in Fall. assert (f 0 < f (tau + width / 2)) by (apply Beyond; lra). lra.
Qed.

(** [V' <= - b (1 - V / level) V] below the level: V falls like [exp(- b (1 - V(0) / level) t)]. *)
Lemma region_decay T V d b level :
  right_continuous_at_0 V -> (forall t, 0 < t < T -> derivable_pt_lim V t (d t)) -> (forall t, 0 <= V t) -> 0 <= b ->
  (forall t, 0 < t < T -> V t < level -> d t <= - (b * (1 - V t / level) * V t)) -> V 0 < level ->
  forall s t, 0 <= s -> s <= t -> t < T -> V t <= exp (- (b * (1 - V 0 / level)) * (t - s)) * V s.
Proof.
  intros Start D Positive Hb Falls Below s t Hs Hst Ht.
  assert (Level : 0 < level) by (specialize (Positive 0); lra).
  assert (Share : forall r, V r < level -> 0 <= b * (1 - V r / level)).
  { intros r R. apply Rmult_le_pos; [exact Hb|]. apply Rmult_le_reg_l with level; [exact Level|].
    replace (level * (1 - V r / level)) with (level - V r) by (field; lra). lra. }
  assert (Stays : forall r, 0 <= r -> r < T -> V r <= V 0).
  { apply (stays_below T V d level); try assumption. intros r R L. specialize (Falls r R L).
    assert (0 <= b * (1 - V r / level) * V r) by (apply Rmult_le_pos; [apply Share, L|apply Positive]). lra. }
  set (c := b * (1 - V 0 / level)).
  assert (K : exp (c * t) * V t <= exp (c * s) * V s).
  { apply (decreasing T (fun t => exp (c * t) * V t) (fun t => c * exp (c * t) * V t + exp (c * t) * d t)); try lra.
    - apply right_continuous_mult; [|exact Start]. apply (right_continuous_derivable _ _ (derivative_exponential c 0)).
    - intros r Hr. apply (derivable_pt_lim_mult (fun t => exp (c * t)) V); [apply derivative_exponential|apply D, Hr].
    - intros r Hr. assert (R : V r <= V 0) by (apply Stays; lra). specialize (Falls r Hr ltac:(lra)).
      pose proof (exp_pos (c * r)). specialize (Positive r).
      replace (c * exp (c * r) * V r + exp (c * r) * d r) with (exp (c * r) * (c * V r + d r)) by ring.
      assert (c * V r <= b * (1 - V r / level) * V r).
      { apply Rmult_le_compat_r; [exact Positive|]. apply Rmult_le_compat_l; [exact Hb|].
        assert (V r / level <= V 0 / level); [|lra]. apply Rmult_le_compat_r; [|exact R].
        apply Rlt_le, Rinv_0_lt_compat, Level. }
      assert (c * V r + d r <= 0) by lra. nra. }
  assert (X : exp (- c * (t - s)) = exp (- c * t) * exp (c * s)) by (rewrite <- exp_plus; f_equal; ring).
  assert (Y : exp (- c * t) * exp (c * t) = 1) by (rewrite <- exp_plus, <- exp_0; f_equal; ring).
  rewrite X, Rmult_assoc. replace (V t) with (exp (- c * t) * (exp (c * t) * V t)).
  - apply Rmult_le_compat_l; [apply Rlt_le, exp_pos|exact K].
  - rewrite <- Rmult_assoc, Y. ring.
Qed.

(** ** The inequalities *)

(** [16 b^3 (2 a - b) <= 27 a^4] *)
Lemma quartic a b : 0 <= a -> 0 <= b -> 16 * b ^ 3 * (2 * a - b) <= 27 * a ^ 4.
Proof.
  intros A B. assert (0 <= (3 * a - 2 * b) ^ 2 * (3 * a ^ 2 + 4 * a * b + 4 * b ^ 2)).
  { apply Rmult_le_pos; [apply pow2_ge_0|]. assert (0 <= a * b) by (apply Rmult_le_pos; assumption).
    pose proof (pow2_ge_0 a). pose proof (pow2_ge_0 b). lra. }
  nra.
Qed.

(** [|x'y| <= |x| |y|] *)
Lemma cauchy_schwarz n (x y : vector) : Rabs (inner n x y) <= norm n x * norm n y.
Proof.
  assert (H : inner n x y * inner n x y <= square n x * square n y).
  { pose proof (square_nonnegative n x). pose proof (square_nonnegative n y).
    assert (K : 0 <= square n (fun i => square n y * x i + - inner n x y * y i)) by apply square_nonnegative.
    unfold square at 1 in K. rewrite (sum_ext n _ (fun i => square n y * square n y * (x i * x i)
      + (- (2 * square n y * inner n x y)) * (x i * y i) + inner n x y * inner n x y * (y i * y i))) in K by (intros;
        ring).
    rewrite !sum_plus, !sum_times in K. fold (square n x) (square n y) (inner n x y) in K.
    destruct (Req_dec (square n y) 0) as [Z|Z].
    - assert (E : inner n x y = 0).
      { unfold inner. rewrite (sum_ext n _ (fun _ => 0)); [apply sum_zero|]. intros i I.
        destruct (Req_dec (y i) 0) as [->|Y]; [ring|]. pose proof (square_positive n y i I Y). lra. }
      rewrite E, Z. lra.
    - apply Rmult_le_reg_l with (square n y); [lra|]. lra. }
  unfold norm. rewrite <- sqrt_mult by apply square_nonnegative. rewrite <- (Rabs_pos_eq (sqrt _)) by apply sqrt_pos.
  apply Rsqr_le_abs_0. rewrite Rsqr_sqrt by (apply Rmult_le_pos; apply square_nonnegative). exact H.
Qed.

Lemma norm_squared n x : norm n x * norm n x = square n x.
Proof. apply sqrt_sqrt, square_nonnegative. Qed.

Lemma norm_nonnegative n x : 0 <= norm n x.
Proof. apply sqrt_pos. Qed.

(** [t y^3 (2 r - mu y)], where positive, is at most [k x^4]. *)
Lemma cubic_excess c t rho kappa mu k x y :
  0 <= x -> 0 <= y -> 0 <= rho -> 0 <= kappa -> 0 < mu -> 0 <= t -> 0 <= c -> c <= t * (y * y) -> y <= kappa * x ->
  27 * t * rho ^ 4 <= 16 * mu ^ 3 * k \/ 2 * t * rho * kappa ^ 3 <= k ->
  c * (2 * rho * x * y - mu * (y * y)) <= k * x ^ 4.
Proof.
  intros X Y Rho Kappa Mu Ht C Ct Yx Which.
  assert (X4 : 0 <= x ^ 4) by (apply pow_le, X). assert (M3 : 0 < mu ^ 3) by (apply pow_lt, Mu).
  assert (K : 0 <= k).
  { destruct Which as [W|W].
    - apply Rmult_le_reg_l with (16 * mu ^ 3); [lra|]. rewrite Rmult_0_r. apply Rle_trans with (2 := W).
      apply Rmult_le_pos; [lra|apply pow_le, Rho].
    - apply Rle_trans with (2 := W). apply Rmult_le_pos; [apply Rmult_le_pos; [lra|exact Rho]|apply pow_le, Kappa]. }
  destruct (Rle_lt_dec (2 * rho * x - mu * y) 0) as [N|P].
  - assert (0 <= c * y * - (2 * rho * x - mu * y)) by (apply Rmult_le_pos; [apply Rmult_le_pos; assumption|lra]).
    assert (0 <= k * x ^ 4) by (apply Rmult_le_pos; assumption). lra.
  - apply Rle_trans with (t * (y * y) * (y * (2 * rho * x - mu * y))).
    { replace (2 * rho * x * y - mu * (y * y)) with (y * (2 * rho * x - mu * y)) by ring.
      apply Rmult_le_compat_r; [|exact Ct]. apply Rmult_le_pos; lra. }
    destruct Which as [W|W].
    + pose proof (quartic (rho * x) (mu * y) ltac:(apply Rmult_le_pos; assumption) ltac:(apply Rmult_le_pos; lra)) as Q.
      apply Rmult_le_reg_l with (16 * mu ^ 3); [lra|].
      apply Rle_trans with (t * (27 * (rho * x) ^ 4)).
      * replace (16 * mu ^ 3 * (t * (y * y) * (y * (2 * rho * x - mu * y))))
          with (t * (16 * (mu * y) ^ 3 * (2 * (rho * x) - mu * y))) by ring.
        apply Rmult_le_compat_l; assumption.
      * replace (t * (27 * (rho * x) ^ 4)) with (27 * t * rho ^ 4 * x ^ 4) by ring.
        replace (16 * mu ^ 3 * (k * x ^ 4)) with (16 * mu ^ 3 * k * x ^ 4) by ring.
        apply Rmult_le_compat_r; assumption.
    + apply Rle_trans with (2 * t * rho * kappa ^ 3 * x ^ 4); [|apply Rmult_le_compat_r; assumption].
      assert (Y3 : y ^ 3 <= (kappa * x) ^ 3) by (apply pow_incr; lra).
      assert (0 <= y ^ 3) by (apply pow_le, Y). assert (0 <= 2 * rho * x) by (apply Rmult_le_pos; lra).
      assert (0 <= mu * y) by (apply Rmult_le_pos; lra).
      apply Rle_trans with (t * (y ^ 3 * (2 * rho * x))).
      * replace (t * (y * y) * (y * (2 * rho * x - mu * y))) with (t * (y ^ 3 * (2 * rho * x - mu * y))) by ring.
        apply Rmult_le_compat_l; [exact Ht|]. apply Rmult_le_compat_l; lra.
      * replace (2 * t * rho * kappa ^ 3 * x ^ 4) with (t * ((kappa * x) ^ 3 * (2 * rho * x))) by ring.
        apply Rmult_le_compat_l; [exact Ht|]. apply Rmult_le_compat_r; assumption.
Qed.

(** ** The statement about trajectories *)

(** [R = P N + C'S] *)
Definition residual_numbers (n p : nat) (C N P S : list (list Q)) : numbers :=
  added n p (times n n p (numbers_of n n P) (numbers_of n p N)) (times n p p (turned n p (numbers_of p n C))
    (numbers_of p p S)).

Definition residual (n p : nat) (C N P S : list (list Q)) : matrix :=
  plus (product n (real P) (real N)) (product p (transpose (real C)) (real S)).

(** The hypotheses of the head. *)
Definition region_decays (n p : nat) (A C L N P theta S : list (list Q))
  (q lower upper overshoot mu t rho kappa level decay : Q) : bool :=
  is_between n P lower upper overshoot &&& falls n p A C L P 0 q &&& is_symmetric n (numbers_of n n P)
    &&& fits n p N &&& fits p p theta &&& fits p p S
    &&& semidefinite p (numbers_of p p theta) &&& at_least p (negative p p (numbers_of p p theta)) (- t)
    &&& at_least p (added p p (numbers_of p p S) (turned p p (numbers_of p p S))) mu
    &&& (let R := residual_numbers n p C N P S in at_least p (negative p p (times p n p (turned p n R) R)) (- (rho *
      rho)))
    &&& at_least n (negative n n (times n p n (turned n p (numbers_of p n C)) (numbers_of p n C))) (- (kappa * kappa))
    &&& (is_positive mu &&& Qle_bool 0 t &&& Qle_bool 0 rho &&& Qle_bool 0 kappa &&& is_positive level &&& is_positive
      decay
         &&& Qle_bool 0 q)
    &&& Qle_bool (2 * decay * upper) q
    &&& (Qle_bool (27 * t * (rho * rho * rho * rho) * level) (16 * (mu * mu * mu) * (q * lower))
         ||| Qle_bool (2 * t * rho * (kappa * kappa * kappa) * level) (q * lower)).

Lemma at_most_gram n m X M q v :
  equals n m X M -> at_least m (negative m m (times m n m (turned m n X) X)) (- (q * q)) = true ->
  square n (apply m M v) <= Q2R q * Q2R q * square m v.
Proof.
  intros E H.
  pose proof (at_least_correct _ _ _ _ (negative_correct _ _ _ _ (times_correct m n m _ _ _ _ (turned_correct m n _ _
    E) E))
    H v) as K.
  unfold form in K. rewrite bilinear_scale, bilinear_transpose_product in K.
  rewrite Q2R_opp, Q2R_mult in K. unfold square at 1. unfold bilinear in K. lra.
Qed.

Lemma not_negative q : Qle_bool 0 q = true -> 0 <= Q2R q.
Proof. intros H. apply Qle_bool_iff, Qle_Rle in H. rewrite Q2R_zero in H. exact H. Qed.

Section Error.
  Variables (n p : nat) (A C L N P theta S : list (list Q)).
  Variables (q lower upper overshoot mu t rho kappa level decay : Q).
  Hypothesis Checked : region_decays n p A C L N P theta S q lower upper overshoot mu t rho kappa level decay = true.

  Lemma region_shapes :
    is_between n P lower upper overshoot = true /\ 0 < Q2R decay /\ 0 < Q2R level
    /\ 2 * Q2R decay * Q2R upper <= Q2R q /\ 0 <= Q2R q
    /\ has_shape n n A = true /\ has_shape p n C = true /\ has_shape n p L = true /\ has_shape n n P = true
    /\ has_shape p p theta = true.
  Proof.
    pose proof Checked as H. unfold region_decays in H.
    apply both in H. destruct H as [H Which]. apply both in H. destruct H as [H Rate]. apply both in H.
    destruct H as [H Signs]. apply both in H. destruct H as [H Kappa]. apply both in H. destruct H as [H Rho].
    apply both in H. destruct H as [H Mu]. apply both in H. destruct H as [H Large]. apply both in H.
    destruct H as [H Theta]. apply both in H. destruct H as [H FS]. apply both in H. destruct H as [H Ft].
    apply both in H. destruct H as [H FN]. apply both in H. destruct H as [H Symmetric]. apply both in H.
    destruct H as [Between Falls]. apply both in Signs. destruct Signs as [Signs QSign].
    apply both in Signs. destruct Signs as [Signs PositiveDecay]. apply both in Signs.
    destruct Signs as [Signs PositiveLevel]. apply both in Signs. destruct Signs as [Signs KappaSign]. apply both in
      Signs.
    destruct Signs as [Signs RhoSign]. apply both in Signs. destruct Signs as [MuSign TSign].
    apply is_positive_correct in PositiveDecay, PositiveLevel, MuSign. apply not_negative in KappaSign, RhoSign,
      TSign, QSign.
    apply Qle_bool_iff, Qle_Rle in Rate. rewrite !Q2R_mult in Rate. replace (Q2R 2) with 2 in Rate by (unfold Q2R;
      simpl; lra).
    pose proof (both _ _ Falls) as [Fit _]. destruct (linear_fits_parts _ _ _ _ _ _ Fit) as (FA & FC & FL & FP).
    pose proof (fits_shape _ _ _ FA) as HA. pose proof (fits_shape _ _ _ FC) as HC. pose proof (fits_shape _ _ _ FL)
      as HL.
    pose proof (fits_shape _ _ _ FP) as HP. pose proof (fits_shape _ _ _ Ft) as Ht.
    destruct (between_numbers _ _ _ _ _ Between) as (Lower & _ & _).
    repeat split; assumption || lra.
  Qed.

  (** Below the level the derivative of V is at most [- q (1 - V / level) |e|^2]. *)
  Lemma region_flow_falls v :
    let f := cubic_flow n p A C L theta (real N) v in
    form n (real P) v < Q2R level ->
    bilinear n n (real P) f v + bilinear n n (real P) v f
      <= - (Q2R q * (1 - form n (real P) v / Q2R level) * square n v).
  Proof.
    intros f Small. unfold f. clear f.
    pose proof Checked as H. unfold region_decays in H.
    apply both in H. destruct H as [H Which]. apply both in H. destruct H as [H Rate]. apply both in H.
    destruct H as [H Signs]. apply both in H. destruct H as [H Kappa]. apply both in H. destruct H as [H Rho].
    apply both in H. destruct H as [H Mu]. apply both in H. destruct H as [H Large]. apply both in H.
    destruct H as [H Theta]. apply both in H. destruct H as [H FS]. apply both in H. destruct H as [H Ft].
    apply both in H. destruct H as [H FN]. apply both in H. destruct H as [H Symmetric]. apply both in H.
    destruct H as [Between Falls]. apply both in Signs. destruct Signs as [Signs QSign].
    apply both in Signs. destruct Signs as [Signs PositiveDecay]. apply both in Signs.
    destruct Signs as [Signs PositiveLevel]. apply both in Signs. destruct Signs as [Signs KappaSign]. apply both in
      Signs.
    destruct Signs as [Signs RhoSign]. apply both in Signs. destruct Signs as [MuSign TSign].
    apply is_positive_correct in PositiveDecay, PositiveLevel, MuSign. apply not_negative in KappaSign, RhoSign,
      TSign, QSign.
    apply Qle_bool_iff, Qle_Rle in Rate. rewrite !Q2R_mult in Rate. replace (Q2R 2) with 2 in Rate by (unfold Q2R;
      simpl; lra).
    pose proof (both _ _ Falls) as [Fit _]. destruct (linear_fits_parts _ _ _ _ _ _ Fit) as (FA & FC & FL & FP).
    pose proof (fits_shape _ _ _ FA) as HA. pose proof (fits_shape _ _ _ FC) as HC. pose proof (fits_shape _ _ _ FL)
      as HL.
    pose proof (fits_shape _ _ _ FP) as HP. pose proof (fits_shape _ _ _ Ft) as Ht.
    destruct (between_numbers _ _ _ _ _ Between) as (Lower & _ & _).
    set (k := Q2R q * Q2R lower / Q2R level).
    assert (Bound : 27 * Q2R t * Q2R rho ^ 4 <= 16 * Q2R mu ^ 3 * k \/ 2 * Q2R t * Q2R rho * Q2R kappa ^ 3 <= k).
    { apply one_of in Which. destruct Which as [W|W]; [left|right]; apply Qle_bool_iff, Qle_Rle in W;
        rewrite !Q2R_mult in W; apply Rmult_le_reg_r with (Q2R level); try exact PositiveLevel.
      - replace (Q2R 27) with 27 in W by (unfold Q2R; simpl; lra). replace (Q2R 16) with 16 in W by (unfold Q2R;
        simpl; lra).
        replace (16 * Q2R mu ^ 3 * k * Q2R level) with (16 * (Q2R mu * Q2R mu * Q2R mu) * (Q2R q * Q2R lower))
          by (unfold k; field; lra). lra.
      - replace (Q2R 2) with 2 in W by (unfold Q2R; simpl; lra).
        replace (k * Q2R level) with (Q2R q * Q2R lower) by (unfold k; field; lra). lra. }
    set (F := error_matrix p A C L).
    set (c := fun v => form p (real theta) (apply n (real C) v)).
    set (y := apply n (real C) v). set (X := norm n v). set (Y := norm p y).
    pose proof (falls_form _ _ _ _ _ _ _ _ Falls v) as Linear. rewrite Q2R_zero, lyapunov_form in Linear. fold F in
      Linear.
    cbv zeta. change (cubic_flow n p A C L theta (real N) v) with (fun i => apply n F v i + c v * apply p (real N) y i).
    rewrite (bilinear_plus_left n n), bilinear_scale_left, (bilinear_plus_right n n), bilinear_scale_right.
    rewrite (is_symmetric_correct n _ _ (apply p (real N) y) v (fits_equals _ _ _ FP) Symmetric).
    assert (Term : bilinear n n (real P) v (apply p (real N) y)
      = inner n v (apply p (residual n p C N P S) y) - form p (real S) y).
    { rewrite <- bilinear_product. change (inner n v (apply p (residual n p C N P S) y)) with (bilinear n p
      (residual n p C N P S)
        v y). unfold residual. rewrite bilinear_plus, bilinear_transpose_product. fold y. unfold form. ring. }
    assert (Residual : inner n v (apply p (residual n p C N P S) y) <= Q2R rho * X * Y).
    { pose proof (cauchy_schwarz n v (apply p (residual n p C N P S) y)) as CS.
      pose proof (at_most_gram n p _ _ rho y (added_correct _ _ _ _ _ _ (times_correct n n p _ _ _ _ (fits_equals _
        _ _ FP)
        (fits_equals _ _ _ FN)) (times_correct n p p _ _ _ _ (turned_correct n p _ _ (fits_equals _ _ _ FC))
        (fits_equals _ _ _ FS))) Rho) as G.
      assert (B : norm n (apply p (residual n p C N P S) y) <= Q2R rho * Y).
      { unfold norm at 1. rewrite <- (sqrt_square (Q2R rho * Y)) by (apply Rmult_le_pos; [exact RhoSign|apply
          norm_nonnegative]).
        apply sqrt_le_1; [apply square_nonnegative|apply Rle_0_sqr|]. unfold residual.
        replace (Q2R rho * Y * (Q2R rho * Y)) with (Q2R rho * Q2R rho * (Y * Y)) by ring. unfold Y.
        rewrite norm_squared. exact G. }
      pose proof (Rle_abs (inner n v (apply p (residual n p C N P S) y))).
      assert (X * norm n (apply p (residual n p C N P S) y) <= X * (Q2R rho * Y)).
      { apply Rmult_le_compat_l; [apply norm_nonnegative|exact B]. }
      fold X in CS. lra. }
    assert (Outputs : Y <= Q2R kappa * X).
    { unfold Y, norm at 1. rewrite <- (sqrt_square (Q2R kappa * X)) by (apply Rmult_le_pos; [exact KappaSign|apply
        norm_nonnegative]).
      apply sqrt_le_1; [apply square_nonnegative|apply Rle_0_sqr|].
      replace (Q2R kappa * X * (Q2R kappa * X)) with (Q2R kappa * Q2R kappa * (X * X)) by ring. unfold X.
      rewrite norm_squared. apply (at_most_gram p n _ _ kappa v (fits_equals _ _ _ FC) Kappa). }
    assert (Weight : 0 <= c v <= Q2R t * (Y * Y)).
    { unfold c. fold y. split; [apply (semidefinite_correct _ _ _ (fits_equals _ _ _ Ft) Theta)|].
      pose proof (at_least_correct _ _ _ _ (negative_correct _ _ _ _ (fits_equals _ _ _ Ft)) Large y) as G.
      unfold form in G. rewrite bilinear_scale, Q2R_opp in G. unfold Y. rewrite norm_squared. unfold form. lra. }
    assert (Accretive : Q2R mu * (Y * Y) <= 2 * form p (real S) y).
    { pose proof (at_least_correct _ _ _ _ (added_correct _ _ _ _ _ _ (fits_equals _ _ _ FS)
        (turned_correct _ _ _ _ (fits_equals _ _ _ FS))) Mu y) as G.
      unfold form in G. rewrite bilinear_plus, bilinear_transpose in G. unfold Y. rewrite norm_squared. unfold form.
        lra. }
    assert (Cubic : c v * (2 * (inner n v (apply p (residual n p C N P S) y) - form p (real S) y)) <= k * X ^ 4).
    { apply Rle_trans with (c v * (2 * Q2R rho * X * Y - Q2R mu * (Y * Y))).
      - apply Rmult_le_compat_l; [apply Weight|lra].
      - apply (cubic_excess _ (Q2R t) _ (Q2R kappa)); try assumption; try apply norm_nonnegative; apply Weight. }
    rewrite Term.
    assert (XX : X * X = square n v) by apply norm_squared.
    pose proof (between_lower _ _ _ _ _ Between v) as Low. pose proof (between_upper _ _ _ _ _ Between v) as High.
    set (V := form n (real P) v) in *. rewrite <- XX in *.
    assert (Share : 0 <= 1 - V / Q2R level).
    { apply Rmult_le_reg_l with (Q2R level); [exact PositiveLevel|].
      replace (Q2R level * (1 - V / Q2R level)) with (Q2R level - V) by (field; lra). lra. }
    assert (V0 : 0 <= V).
    { apply Rle_trans with (2 := Low). apply Rmult_le_pos; [lra|apply Rle_0_sqr]. }
    (* k X^4 <= q X^2 V / level *)
    assert (Quartic : k * X ^ 4 <= Q2R q * (V / Q2R level) * (X * X)).
    { replace (k * X ^ 4) with (Q2R q * (Q2R lower * (X * X) / Q2R level) * (X * X)) by (unfold k; field; lra).
      apply Rmult_le_compat_r; [apply Rle_0_sqr|]. apply Rmult_le_compat_l; [exact QSign|].
      apply Rmult_le_compat_r; [apply Rlt_le, Rinv_0_lt_compat, PositiveLevel|exact Low]. }
    fold V in Linear. lra.
  Qed.

  (** It is at most [- 2 decay (1 - V / level) V]. *)
  Lemma region_flow_decays v :
    let f := cubic_flow n p A C L theta (real N) v in
    form n (real P) v < Q2R level ->
    bilinear n n (real P) f v + bilinear n n (real P) v f
      <= - (2 * Q2R decay * (1 - form n (real P) v / Q2R level) * form n (real P) v).
  Proof.
    intros f Small. apply Rle_trans with (1 := region_flow_falls v Small).
    destruct region_shapes as (Between & PositiveDecay & PositiveLevel & Rate & _ & _).
    pose proof (between_upper _ _ _ _ _ Between v) as High. set (V := form n (real P) v) in *.
    assert (Share : 0 <= 1 - V / Q2R level).
    { apply Rmult_le_reg_l with (Q2R level); [exact PositiveLevel|].
      replace (Q2R level * (1 - V / Q2R level)) with (Q2R level - V) by (field; lra). lra. }
    assert (Speed : 2 * Q2R decay * V <= Q2R q * square n v).
    { apply Rle_trans with (2 * Q2R decay * (Q2R upper * square n v)); [apply Rmult_le_compat_l; lra|].
      replace (2 * Q2R decay * (Q2R upper * square n v)) with (2 * Q2R decay * Q2R upper * square n v) by ring.
      apply Rmult_le_compat_r; [apply square_nonnegative|exact Rate]. }
    assert ((1 - V / Q2R level) * (2 * Q2R decay * V) <= (1 - V / Q2R level) * (Q2R q * square n v)).
    { apply Rmult_le_compat_l; assumption. }
    lra.
  Qed.

  (** Solutions from below the level decay, faster from smaller errors. *)
  Theorem region_error_decays (T : R) (e : R -> vector) :
    solution T n e (fun t => cubic_error p A C L theta (real N) (e t)) ->
    quadratic n P (e 0) < Q2R level ->
    let a := Q2R decay * (1 - quadratic n P (e 0) / Q2R level) in
    0 < a
    /\ (forall s t, 0 <= s -> s <= t -> t < T ->
      quadratic n P (e t) <= exp (- (2 * a) * (t - s)) * quadratic n P (e s))
    /\ (forall t, 0 <= t -> t < T -> norm n (e t) <= Q2R overshoot * exp (- a * t) * norm n (e 0)).
  Proof.
    intros E Below a.
    destruct region_shapes as (Between & PositiveDecay & PositiveLevel & _ & _ & HA & HC & HL & HP & Ht).
    destruct (between_numbers _ _ _ _ _ Between) as (Lower & _ & _).
    set (f := cubic_flow n p A C L theta (real N)).
    assert (S' : solution T n e (fun t => f (e t))).
    { apply (solution_ext T n e (fun t => cubic_error p A C L theta (real N) (e t))); [|exact E].
      intros t' i I. apply cubic_error_flow; assumption. }
    assert (A0 : 0 < a).
    { unfold a. apply Rmult_lt_0_compat; [exact PositiveDecay|]. apply Rmult_lt_reg_l with (Q2R level); [exact
      PositiveLevel|].
      replace (Q2R level * (1 - quadratic n P (e 0) / Q2R level)) with (Q2R level - quadratic n P (e 0)) by (field;
        lra). lra. }
    assert (K : forall s t, 0 <= s -> s <= t -> t < T ->
      quadratic n P (e t) <= exp (- (2 * a) * (t - s)) * quadratic n P (e s)).
    { intros s r Hs Hsr Hr.
      replace (- (2 * a)) with (- (2 * Q2R decay * (1 - quadratic n P (e 0) / Q2R level))) by (unfold a; ring).
      rewrite !(quadratic_form n P) by exact HP. rewrite (quadratic_form n P) in Below by exact HP.
      apply (region_decay T (fun t => form n (real P) (e t))
        (fun t => bilinear n n (real P) (f (e t)) (e t) + bilinear n n (real P) (e t) (f (e t))) (2 * Q2R decay) (Q2R
          level));
        try assumption; try lra.
      - apply right_continuous_form. intros i I. apply (S' i I).
      - intros x Hx. apply derivative_form. intros i I. apply (S' i I). exact Hx.
      - intros x. apply Rle_trans with (Q2R lower * square n (e x)); [apply Rmult_le_pos; [lra|apply
        square_nonnegative]|].
        apply (between_lower _ _ _ _ _ Between).
      - intros x _ L'. apply region_flow_decays, L'. }
    split; [exact A0|]. split; [exact K|]. intros r Hs Hr.
    apply (norm_of_form n P lower upper overshoot Between); [apply Rlt_le, exp_pos|].
    specialize (K 0 r (Rle_refl 0) Hs Hr). rewrite !(quadratic_form n P), Rminus_0_r in K by exact HP.
    rewrite <- (quadratic_form n P) in K by exact HP.
    replace (exp (- a * r) * exp (- a * r)) with (exp (- (2 * a) * r)).
    - unfold a in *. rewrite !(quadratic_form n P) in * by exact HP. exact K.
    - rewrite <- exp_plus. f_equal. ring.
  Qed.
End Error.
