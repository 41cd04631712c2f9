(** The loop [u = -K xhat] around a cubic observer that converges from an ellipsoid, with its gains as stored: the
    theorem [feedback-loop] of certificates with a level.

    While [V = e'Pe] is below the level, it has the derivative [V' <= - q (1 - V / level) |e|^2] (CubicRegion.v), and it
    does not grow. With [share = 1 - V(0) / level] the sum [W = share x'P1 x + e'Pe] has
    [W' <= share (x'(He((A - BK)'P1))x + 2 x'P1 B K e - q |e|^2)], and where
    [[He((A - BK)'P1) + 2 a P1, P1 B K; *, (2 a upper - q) I] <= 0], [P <= upper I], that is at most [- 2 a share W]. *)

From Coq Require Import Reals QArith Qreals ZArith List Lra Lia.
From Luenberger Require Import Vectors Definite Inequalities Decay LinearObserver CubicObserver CubicRegion FeedbackLoop
  Blocks Solutions CubicExistence.
Import ListNotations.
Local Open Scope R_scope.
Local Open Scope lazy_bool_scope.

(** [[He((A - BK)'P1) + 2 a P1, P1 B K; *, (2 a upper - q) I]] *)
Definition driven_numbers (n m : nat) (A B K P1 : list (list Q)) (a upper q : Q) : numbers :=
  let BK := times n m n (numbers_of n m B) (numbers_of m n K) in
  in_blocks n n (lyapunov_numbers n (error_numbers n m A K B) (numbers_of n n P1) a)
    (times n n n (numbers_of n n P1) BK) (times n n n (turned n n BK) (numbers_of n n P1))
    (multiple_of_identity n (2 * a * upper - q)).

Definition driven_matrix (n m : nat) (A B K P1 : list (list Q)) (a upper q : R) : matrix :=
  let BK := product m (real B) (real K) in
  blocks n (lyapunov_matrix n (error_matrix m A K B) (real P1) a)
    (product n (real P1) BK) (product n (transpose BK) (real P1)) (scale (2 * a * upper - q) identity).

Definition is_driven (n m : nat) (A B K P1 : list (list Q)) (a upper q : Q) : bool :=
  linear_fits n m A K B P1
    &&& semidefinite (n + n) (negative (n + n) (n + n) (driven_numbers n m A B K P1 a upper q)).

(** The derivative of [x'P1 x] at (v, w), less [q |w|^2]. *)
Lemma is_driven_form n m A B K P1 a upper q (v w : vector) :
  is_driven n m A B K P1 a upper q = true ->
  let f := loop_flow A B K v w in
  bilinear n n (real P1) f v + bilinear n n (real P1) v f - Q2R q * square n w
    <= - (2 * Q2R a * (form n (real P1) v + Q2R upper * square n w)).
Proof.
  intros H f. apply both in H. destruct H as [Fit H].
  destruct (linear_fits_parts _ _ _ _ _ _ Fit) as (FA & FK & FB & FP1).
  pose proof (times_correct n m n _ _ _ _ (fits_equals _ _ _ FB) (fits_equals _ _ _ FK)) as BK.
  assert (E : equals (n + n) (n + n) (driven_numbers n m A B K P1 a upper q)
    (driven_matrix n m A B K P1 (Q2R a) (Q2R upper) (Q2R q))).
  { apply in_blocks_correct.
    - apply lyapunov_numbers_correct; [apply error_numbers_correct; assumption|apply fits_equals, FP1].
    - apply times_correct; [apply fits_equals, FP1|exact BK].
    - apply times_correct; [apply turned_correct, BK|apply fits_equals, FP1].
    - replace (2 * Q2R a * Q2R upper - Q2R q) with (Q2R (2 * a * upper - q)); [apply multiple_of_identity_correct|].
      rewrite Q2R_minus, !Q2R_mult. replace (Q2R 2) with 2 by (unfold Q2R; simpl; lra). ring. }
  pose proof (semidefinite_correct _ _ _ (negative_correct _ _ _ _ E) H (pair_of n v w)) as K'.
  unfold form in K' at 1. rewrite bilinear_scale in K'. unfold driven_matrix in K'. cbv zeta in K'.
  rewrite bilinear_blocks, bilinear_scale, bilinear_product, bilinear_transpose_product in K'.
  fold (form n (lyapunov_matrix n (error_matrix m A K B) (real P1) (Q2R a)) v) (form n identity w) in K'.
  rewrite form_identity, lyapunov_form in K'.
  set (g := apply n (error_matrix m A K B) v) in *. set (h := apply n (product m (real B) (real K)) w) in *.
  assert (Flow : forall i, (i < n)%nat -> f i = g i + h i).
  { intros i I. unfold f, loop_flow. unfold plus_vector at 1. f_equal.
    - unfold g. rewrite (error_apply n m) by (try exact I; eapply fits_shape; eassumption). reflexivity.
    - unfold h. rewrite apply_product, (times_vector_apply n m B) by (try exact I; eapply fits_shape; eassumption).
      apply apply_ext; [reflexivity|]. intros j J. apply (times_vector_apply m n K);
        [eapply fits_shape; eassumption|exact J]. }
  rewrite (bilinear_ext n n (real P1) (real P1) f v (fun i => g i + h i) v) by (try exact Flow; easy).
  rewrite (bilinear_ext n n (real P1) (real P1) v f v (fun i => g i + h i)) by (try exact Flow; easy).
  rewrite (bilinear_plus_left n n), (bilinear_plus_right n n). unfold form at 1. unfold form in K'. lra.
Qed.

(** The observer converges from below the level, and the loop is driven by its error. *)
Definition region_loop_decays (n m p : nat) (A B C K L N P1 P theta S : list (list Q))
  (q lower upper overshoot mu t rho kappa level decay a lower_loop upper_loop overshoot_loop : Q) : bool :=
  region_decays n p A C L N P theta S q lower upper overshoot mu t rho kappa level decay
    &&& is_between n P lower_loop upper_loop overshoot_loop &&& is_between n P1 lower_loop upper_loop overshoot_loop
    &&& is_positive a &&& is_driven n m A B K P1 a upper q.

(** [c x'P1 x + e'Pe] *)
Definition shared_matrix (n : nat) (c : R) (P1 P : list (list Q)) : matrix :=
  blocks n (scale c (real P1)) nothing nothing (real P).

Lemma shared_form n c P1 P v w :
  form (n + n) (shared_matrix n c P1 P) (pair_of n v w) = c * form n (real P1) v + form n (real P) w.
Proof. unfold form, shared_matrix. rewrite bilinear_blocks, !bilinear_nothing, bilinear_scale. ring. Qed.

Section Loop.
  Variables (n m p : nat) (A B C K L N P1 P theta S : list (list Q)).
  Variables (q lower upper overshoot mu t rho kappa level decay a lower_loop upper_loop overshoot_loop : Q).
  Hypothesis Checked : region_loop_decays n m p A B C K L N P1 P theta S q lower upper overshoot mu t rho kappa level
    decay a lower_loop upper_loop overshoot_loop = true.

  Lemma region_loop_parts :
    region_decays n p A C L N P theta S q lower upper overshoot mu t rho kappa level decay = true
    /\ is_between n P lower_loop upper_loop overshoot_loop = true
    /\ is_between n P1 lower_loop upper_loop overshoot_loop = true
    /\ 0 < Q2R a /\ is_driven n m A B K P1 a upper q = true
    /\ has_shape n m B = true /\ has_shape m n K = true /\ has_shape n n P1 = true.
  Proof.
    pose proof Checked as H. apply both in H. destruct H as [H Driven]. apply both in H. destruct H as [H Sign].
    apply both in H. destruct H as [H Between1]. apply both in H. destruct H as [Region Between].
    apply is_positive_correct in Sign. pose proof (both _ _ Driven) as [Fit _].
    destruct (linear_fits_parts _ _ _ _ _ _ Fit) as (_ & FK & FB & FP1).
    pose proof (fits_shape _ _ _ FK). pose proof (fits_shape _ _ _ FB). pose proof (fits_shape _ _ _ FP1).
    repeat split; assumption.
  Qed.

  (** [c x'P1 x + e'Pe] falls where c is at most what is left of the level. *)
  Lemma region_loop_falls c v w :
    0 < c -> c <= 1 - form n (real P) w / Q2R level -> form n (real P) w < Q2R level ->
    let z := pair_of n v w in
    let f := pair_of n (loop_flow A B K v w) (cubic_error p A C L theta (real N) w) in
    bilinear (n + n) (n + n) (shared_matrix n c P1 P) f z + bilinear (n + n) (n + n) (shared_matrix n c P1 P) z f
      + 2 * (Q2R a * c) * form (n + n) (shared_matrix n c P1 P) z <= 0.
  Proof.
    intros Positive Small Below z f. unfold z, f. clear z f.
    destruct region_loop_parts as (Region & Between & Between1 & Rate & Driven & HB & HK & HP1).
    destruct (region_shapes _ _ _ _ _ _ _ _ _ _ _ _ _ _ _ _ _ _ _ Region)
      as (BetweenP & Decay & Level & Speed & Q0 & HA & HC & HL & HP & Ht).
    destruct (between_numbers _ _ _ _ _ BetweenP) as (Lower & _ & _).
    destruct (between_numbers _ _ _ _ _ Between1) as (Lower1 & _ & _).
    pose proof (is_driven_form n m A B K P1 a upper q v w Driven) as X. cbv zeta in X.
    pose proof (region_flow_falls _ _ _ _ _ _ _ _ _ _ _ _ _ _ _ _ _ _ _ Region w Below) as E. cbv zeta in E.
    rewrite shared_form. unfold shared_matrix. rewrite !bilinear_blocks, !bilinear_nothing, !bilinear_scale.
    assert (F : forall i, (i < n)%nat ->
      cubic_error p A C L theta (real N) w i = cubic_flow n p A C L theta (real N) w i).
    { intros i I. apply cubic_error_flow; assumption. }
    rewrite (bilinear_ext n n (real P) (real P) (cubic_error p A C L theta (real N) w) w
      (cubic_flow n p A C L theta (real N) w) w) by (try exact F; easy).
    rewrite (bilinear_ext n n (real P) (real P) w (cubic_error p A C L theta (real N) w) w
      (cubic_flow n p A C L theta (real N) w)) by (try exact F; easy).
    set (dx := bilinear n n (real P1) (loop_flow A B K v w) v + bilinear n n (real P1) v (loop_flow A B K v w)) in *.
    set (de := bilinear n n (real P) (cubic_flow n p A C L theta (real N) w) w
      + bilinear n n (real P) w (cubic_flow n p A C L theta (real N) w)) in *.
    set (V := form n (real P) w) in *. set (W := form n (real P1) v) in *. set (s := square n w) in *.
    assert (S0 : 0 <= s) by apply square_nonnegative.
    assert (V0 : 0 <= V).
    { apply Rle_trans with (2 := between_lower _ _ _ _ _ BetweenP w). apply Rmult_le_pos; [lra|exact S0]. }
    assert (W0 : 0 <= W).
    { apply Rle_trans with (2 := between_lower _ _ _ _ _ Between1 v).
      apply Rmult_le_pos; [lra|apply square_nonnegative]. }
    pose proof (between_upper _ _ _ _ _ BetweenP w) as High. fold V s in High.
    assert (C1 : c <= 1).
    { assert (0 <= V / Q2R level) by (apply Rmult_le_pos; [exact V0|apply Rlt_le, Rinv_0_lt_compat, Level]). lra. }
    (* - q (1 - V / level) |e|^2 <= - q c |e|^2 *)
    assert (E' : de <= - (Q2R q * c * s)).
    { apply Rle_trans with (1 := E). apply Ropp_le_contravar. apply Rmult_le_compat_r; [exact S0|].
      apply Rmult_le_compat_l; assumption. }
    assert (X' : c * dx <= c * (Q2R q * s - 2 * Q2R a * (W + Q2R upper * s))).
    { apply Rmult_le_compat_l; lra. }
    assert (Y : 2 * (Q2R a * c) * (c * W + V) <= 2 * (Q2R a * c) * (W + Q2R upper * s)).
    { apply Rmult_le_compat_l; [apply Rmult_le_pos; [lra|apply Rmult_le_pos; lra]|].
      assert (c * W <= 1 * W) by (apply Rmult_le_compat_r; assumption). lra. }
    unfold dx, de in *. lra.
  Qed.

  (** Solutions from e(0) below the level, from every x(0). *)
  Theorem region_loop_decay (T : R) (x xhat : R -> vector) :
    solution T n x (fun t => A * x t - B * (K * xhat t))%vector ->
    solution T n xhat (fun t => let r := (C * x t - C * xhat t)%vector in
      (A * xhat t - B * (K * xhat t) + L * r - quadratic p theta r .* apply p (real N) r)%vector) ->
    let e t := (x t - xhat t)%vector in
    quadratic n P (e 0) < Q2R level ->
    let share := 1 - quadratic n P (e 0) / Q2R level in
    0 < share
    /\ (forall s t, 0 <= s -> s <= t -> t < T ->
      share * quadratic n P1 (x t) + quadratic n P (e t)
        <= exp (- (2 * (Q2R a * share)) * (t - s)) * (share * quadratic n P1 (x s) + quadratic n P (e s)))
    /\ (forall t, 0 <= t -> t < T ->
      norm_of_pair n (x t) (e t)
        <= Q2R overshoot_loop / sqrt share * exp (- (Q2R a * share) * t) * norm_of_pair n (x 0) (e 0)).
  Proof.
    intros Plant Observer e Below share.
    destruct region_loop_parts as (Region & Between & Between1 & Rate & Driven & HB & HK & HP1).
    destruct (region_shapes _ _ _ _ _ _ _ _ _ _ _ _ _ _ _ _ _ _ _ Region)
      as (BetweenP & Decay & Level & Speed & Q0 & HA & HC & HL & HP & Ht).
    destruct (loop_solution n m p A B C K L theta HA HB HC HK HL Ht (real N) T x xhat Plant Observer) as [X E].
    fold e in X, E. change (fun t => (x t - xhat t)%vector) with e in E.
    pose proof (pair_solution T n x e _ _ X E) as Z.
    destruct (region_error_decays _ _ _ _ _ _ _ _ _ _ _ _ _ _ _ _ _ _ _ Region T e E Below) as (A0 & Falls & _).
    set (b := Q2R decay * (1 - quadratic n P (e 0) / Q2R level)) in *.
    assert (Share : 0 < share).
    { apply Rmult_lt_reg_l with (Q2R level); [exact Level|]. unfold share.
      replace (Q2R level * (1 - quadratic n P (e 0) / Q2R level)) with (Q2R level - quadratic n P (e 0))
        by (field; lra). lra. }
    assert (V0 : forall v, 0 <= form n (real P) v).
    { intros v. apply Rle_trans with (2 := between_lower _ _ _ _ _ Between v).
      destruct (between_numbers _ _ _ _ _ Between) as (Lower & _ & _).
      apply Rmult_le_pos; [lra|apply square_nonnegative]. }
    assert (Stays : forall t, 0 <= t -> t < T -> quadratic n P (e t) <= quadratic n P (e 0)).
    { intros r H0 H1. apply Rle_trans with (1 := Falls 0 r (Rle_refl 0) H0 H1).
      rewrite !quadratic_form by exact HP. replace (form n (real P) (e 0)) with (1 * form n (real P) (e 0)) at 2 by
        ring.
      apply Rmult_le_compat_r; [apply V0|]. rewrite <- exp_0, Rminus_0_r.
      assert (N0 : - (2 * b) * r <= 0) by (assert (0 <= 2 * b * r) by (apply Rmult_le_pos; lra); lra).
      destruct N0 as [N0| ->]; [apply Rlt_le, exp_increasing, N0|lra]. }
    assert (W : forall s t, 0 <= s -> s <= t -> t < T ->
      share * quadratic n P1 (x t) + quadratic n P (e t)
        <= exp (- (2 * (Q2R a * share)) * (t - s)) * (share * quadratic n P1 (x s) + quadratic n P (e s))).
    { intros s r Hs Hsr Hr. rewrite !quadratic_form by assumption. rewrite <- !shared_form.
      apply (lyapunov_decay (n + n) (shared_matrix n share P1 P) (Q2R a * share) T (fun t => pair_of n (x t) (e t)) _
        Z);
        try assumption.
      intros y Hy. specialize (Stays y ltac:(lra) ltac:(lra)). unfold share in Share |- *.
      rewrite !quadratic_form in * by exact HP. apply region_loop_falls; [exact Share| |lra].
      assert (form n (real P) (e y) / Q2R level <= form n (real P) (e 0) / Q2R level); [|lra].
      apply Rmult_le_compat_r; [apply Rlt_le, Rinv_0_lt_compat, Level|exact Stays]. }
    split; [exact Share|]. split; [exact W|]. intros r H0 H1. specialize (W 0 r (Rle_refl 0) H0 H1).
    rewrite Rminus_0_r in W. destruct (between_numbers _ _ _ _ _ Between) as (Positive & Sign & Big).
    assert (Share1 : share <= 1).
    { unfold share. assert (0 <= quadratic n P (e 0) / Q2R level); [|lra]. rewrite quadratic_form by exact HP.
      apply Rmult_le_pos; [apply V0|apply Rlt_le, Rinv_0_lt_compat, Level]. }
    assert (Root : 0 < sqrt share) by (apply sqrt_lt_R0, Share).
    assert (SS : sqrt share * sqrt share = share) by (apply sqrt_sqrt; lra).
    apply (root_of_bound (Q2R lower_loop * share) (Q2R upper_loop) (Q2R overshoot_loop / sqrt share)
      (exp (- (Q2R a * share) * r)) (share * quadratic n P1 (x r) + quadratic n P (e r))
      (share * quadratic n P1 (x 0) + quadratic n P (e 0))).
    - apply Rmult_lt_0_compat; assumption.
    - apply Rmult_le_pos; [exact Sign|apply Rlt_le, Rinv_0_lt_compat, Root].
    - replace (Q2R overshoot_loop / sqrt share * (Q2R overshoot_loop / sqrt share) * (Q2R lower_loop * share))
        with (Q2R overshoot_loop * Q2R overshoot_loop * Q2R lower_loop * (share / (sqrt share * sqrt share)))
        by (field; lra).
      rewrite SS. replace (share / share) with 1 by (field; lra). lra.
    - apply Rlt_le, exp_pos.
    - apply Rplus_le_le_0_compat; apply square_nonnegative.
    - apply Rplus_le_le_0_compat; apply square_nonnegative.
    - rewrite !quadratic_form by assumption. pose proof (between_lower _ _ _ _ _ Between1 (x r)) as Lx.
      pose proof (between_lower _ _ _ _ _ Between (e r)) as Le.
      assert (share * (Q2R lower_loop * square n (x r)) <= share * form n (real P1) (x r))
        by (apply Rmult_le_compat_l; lra).
      assert (0 <= Q2R lower_loop * square n (e r)) by (apply Rmult_le_pos; [lra|apply square_nonnegative]).
      assert (share * (Q2R lower_loop * square n (e r)) <= 1 * (Q2R lower_loop * square n (e r)))
        by (apply Rmult_le_compat_r; lra).
      lra.
    - replace (exp (- (Q2R a * share) * r) * exp (- (Q2R a * share) * r)) with (exp (- (2 * (Q2R a * share)) * r));
        [exact W|]. rewrite <- exp_plus. f_equal. ring.
    - rewrite !quadratic_form by assumption. pose proof (between_upper _ _ _ _ _ Between1 (x 0)) as Ux.
      pose proof (between_upper _ _ _ _ _ Between (e 0)).
      assert (0 <= form n (real P1) (x 0)).
      { apply Rle_trans with (2 := between_lower _ _ _ _ _ Between1 (x 0)).
        apply Rmult_le_pos; [lra|apply square_nonnegative]. }
      assert (share * form n (real P1) (x 0) <= 1 * form n (real P1) (x 0)) by (apply Rmult_le_compat_r; assumption).
      lra.
  Qed.

  (** From every x(0) and every e(0) below the level there are such solutions. *)
  Theorem region_loops_exist (x0 xhat0 : vector) :
    quadratic n P (x0 - xhat0)%vector < Q2R level ->
    exists x xhat : R -> vector,
      (forall i, (i < n)%nat -> x 0 i = x0 i /\ xhat 0 i = xhat0 i) /\ forall T,
      solution T n x (fun t => A * x t - B * (K * xhat t))%vector
      /\ solution T n xhat (fun t => let r := (C * x t - C * xhat t)%vector in
           (A * xhat t - B * (K * xhat t) + L * r - quadratic p theta r .* apply p (real N) r)%vector).
  Proof.
    intros Below.
    destruct region_loop_parts as (Region & Between & Between1 & Rate & Driven & HB & HK & HP1).
    destruct (region_shapes _ _ _ _ _ _ _ _ _ _ _ _ _ _ _ _ _ _ _ Region)
      as (BetweenP & Decay & Level & Speed & Q0 & HA & HC & HL & HP & Ht).
    destruct (between_numbers _ _ _ _ _ Between) as (Positive & _ & _).
    rewrite quadratic_form in Below by exact HP. set (V := form n (real P) (x0 - xhat0)%vector) in *.
    set (X := form n (real P1) x0).
    assert (V0 : forall v, 0 <= form n (real P) v).
    { intros v. apply Rle_trans with (2 := between_lower _ _ _ _ _ Between v).
      apply Rmult_le_pos; [lra|apply square_nonnegative]. }
    assert (X0 : forall v, 0 <= form n (real P1) v).
    { intros v. apply Rle_trans with (2 := between_lower _ _ _ _ _ Between1 v).
      apply Rmult_le_pos; [lra|apply square_nonnegative]. }
    (* Halfway to the level, and a weight of x so small that the sum is below that. *)
    set (half := (V + Q2R level) / 2). assert (Half : V < half < Q2R level) by (unfold half; lra).
    assert (VV : 0 <= V) by apply V0. assert (XX : 0 <= X) by apply X0.
    set (c := Rmin (1 - half / Q2R level) ((half - V) / (X + 1))).
    assert (Left : 0 < 1 - half / Q2R level).
    { apply Rmult_lt_reg_l with (Q2R level); [exact Level|].
      replace (Q2R level * (1 - half / Q2R level)) with (Q2R level - half) by (field; lra). lra. }
    assert (C0 : 0 < c).
    { apply Rmin_glb_lt; [exact Left|]. apply Rdiv_lt_0_compat; lra. }
    assert (C1 : c <= 1 - half / Q2R level) by apply Rmin_l.
    assert (C2 : c * (X + 1) <= half - V).
    { apply Rle_trans with ((half - V) / (X + 1) * (X + 1)); [apply Rmult_le_compat_r; [lra|apply Rmin_r]|].
      apply Req_le. field. lra. }
    set (low := Q2R lower_loop * c).
    assert (One : c <= 1).
    { assert (0 <= half / Q2R level) by (apply Rmult_le_pos; [lra|apply Rlt_le, Rinv_0_lt_compat, Level]). lra. }
    apply (loops_exist_below n m p A B C K L theta (real N) HA HB HC HK HL Ht (shared_matrix n c P1 P) low half).
    - apply Rmult_lt_0_compat; assumption.
    - intros v w. rewrite shared_form. pose proof (between_lower _ _ _ _ _ Between1 v) as Lv.
      pose proof (between_lower _ _ _ _ _ Between w) as Lw.
      assert (c * (Q2R lower_loop * square n v) <= c * form n (real P1) v) by (apply Rmult_le_compat_l; lra).
      assert (0 <= Q2R lower_loop * square n w) by (apply Rmult_le_pos; [lra|apply square_nonnegative]).
      assert (c * (Q2R lower_loop * square n w) <= 1 * (Q2R lower_loop * square n w))
        by (apply Rmult_le_compat_r; lra).
      unfold low. lra.
    - intros v w Inside. rewrite shared_form in Inside. cbv zeta.
      assert (0 <= c * form n (real P1) v) by (apply Rmult_le_pos; [lra|apply X0]).
      assert (Vw : form n (real P) w < half) by lra.
      pose proof (region_loop_falls c v w C0) as D. cbv zeta in D. rewrite shared_form in D.
      assert (0 <= 2 * (Q2R a * c) * (c * form n (real P1) v + form n (real P) w)).
      { apply Rmult_le_pos; [apply Rmult_le_pos; [lra|apply Rmult_le_pos; lra]|]. pose proof (V0 w). lra. }
      assert (form n (real P) w / Q2R level <= half / Q2R level).
      { apply Rmult_le_compat_r; [apply Rlt_le, Rinv_0_lt_compat, Level|lra]. }
      specialize (D ltac:(lra) ltac:(lra)). lra.
    - rewrite shared_form. fold X V. lra.
  Qed.
End Loop.
