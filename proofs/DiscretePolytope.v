(** One gain for a polytope of matrices in discrete time: the theorem [discrete-polytope-of-jacobians] of certificates.

    [e(k+1) = (A(k) - L C(k))e(k)] with (A(k), C(k)) in the convex hull of vertices. [V = e'Pe] is convex: where it
      falls
    by [factor^2] with the matrices of every vertex, it does on the hull. *)

From Coq Require Import Reals QArith Qreals ZArith List Lra Lia.
From Luenberger Require Import Vectors Definite Inequalities Decay DiscreteObserver Blocks Refuted Polytope.
Import ListNotations.
Local Open Scope R_scope.
Local Open Scope lazy_bool_scope.

(** ** The inequality at a vertex *)

(** [[factor^2 P, F'P; P F, P]] *)
Definition schur_numbers (n : nat) (F P : numbers) (factor : Q) : numbers :=
  in_blocks n n (multiple n n (factor * factor) P) (times n n n (turned n n F) P) (times n n n P F) P.

Definition schur_matrix (n : nat) (F P : matrix) (factor : R) : matrix :=
  blocks n (scale (factor * factor) P) (product n (transpose F) P) (product n P F) P.

Lemma schur_numbers_correct n F P factor MF MP :
  equals n n F MF -> equals n n P MP ->
  equals (n + n) (n + n) (schur_numbers n F P factor) (schur_matrix n MF MP (Q2R factor)).
Proof.
  intros HF HP. unfold schur_matrix. rewrite <- Q2R_mult. apply in_blocks_correct.
  - apply multiple_correct, HP.
  - apply times_correct; [apply turned_correct|]; assumption.
  - apply times_correct; assumption.
  - exact HP.
Qed.

(** [factor^2 v'Pv + w'P(Fv) + (Fv)'Pw + w'Pw], with the matrices of the certificate. *)
Lemma schur_form n p A C L P factor (v w : vector) :
  linear_fits n p A C L P = true ->
  let f := (A * v - L * (C * v))%vector in
  form (n + n) (schur_matrix n (error_matrix p A C L) (real P) factor) (pair_of n v w)
  = factor ^ 2 * quadratic n P v + inner n f (P * w)%vector + inner n w (P * f)%vector + quadratic n P w.
Proof.
  intros Fit f. destruct (linear_fits_parts _ _ _ _ _ _ Fit) as (FA & FC & FL & FP).
  assert (Flow : forall i, (i < n)%nat -> apply n (error_matrix p A C L) v i = f i).
  { intros i I. symmetry. apply (error_apply n p); try exact I; eapply fits_shape; eassumption. }
  unfold form, schur_matrix. rewrite bilinear_blocks, bilinear_scale, bilinear_transpose_product, bilinear_product.
  rewrite (bilinear_ext n n (real P) (real P) _ w f w) by (try exact Flow; easy).
  rewrite (bilinear_ext n n (real P) (real P) w _ w f) by (try exact Flow; easy).
  rewrite !inner_bilinear, !quadratic_form by (eapply fits_shape; eassumption). unfold form. ring.
Qed.

Definition contracts_at (n p : nat) (A C L P : list (list Q)) (factor q : Q) : bool :=
  linear_fits n p A C L P
    &&& at_least (n + n) (schur_numbers n (error_numbers n p A C L) (numbers_of n n P) factor) q.

(** The fact of a vertex, with its margin q. *)
Theorem schur_inequality n p A C L P factor q :
  is_positive q &&& contracts_at n p A C L P factor q = true ->
  0 < Q2R q /\ forall v w : vector, let f := (A * v - L * (C * v))%vector in
  Q2R q * (square n v + square n w)
    <= Q2R factor ^ 2 * quadratic n P v + inner n f (P * w)%vector + inner n w (P * f)%vector + quadratic n P w.
Proof.
  intros H. apply both in H. destruct H as [Positive H]. split; [apply is_positive_correct, Positive|].
  intros v w f. apply both in H. destruct H as [Fit H].
  destruct (linear_fits_parts _ _ _ _ _ _ Fit) as (FA & FC & FL & FP).
  pose proof (at_least_correct _ _ _ _ (schur_numbers_correct n _ _ factor _ _ (error_numbers_correct _ _ _ _ _ FA FC
    FL)
    (fits_equals _ _ _ FP)) H (pair_of n v w)) as K.
  rewrite square_pair, schur_form in K by exact Fit. fold f in K. exact K.
Qed.

(** It is false: a vector of 2n entries that shows it. *)
Theorem no_schur_inequality n p A C L P factor z :
  linear_fits n p A C L P
    &&& is_witness false (n + n) (schur_numbers n (error_numbers n p A C L) (numbers_of n n P) factor) z = true ->
  exists v w : vector, 0 < square n v + square n w /\
    let f := (A * v - L * (C * v))%vector in
    Q2R factor ^ 2 * quadratic n P v + inner n f (P * w)%vector + inner n w (P * f)%vector + quadratic n P w <= 0.
Proof.
  intros H. apply both in H. destruct H as [Fit H].
  destruct (linear_fits_parts _ _ _ _ _ _ Fit) as (FA & FC & FL & FP).
  destruct (is_witness_correct _ _ _ _ _ (schur_numbers_correct n _ _ factor _ _ (error_numbers_correct _ _ _ _ _ FA
    FC FL)
    (fits_equals _ _ _ FP)) H) as (N & R & _).
  set (v := column z) in *. set (w := (fun i => v (n + i)%nat) : vector).
  assert (E : forall i, (i < n + n)%nat -> v i = pair_of n v w i).
  { apply each_of_pair; intros i I; [rewrite pair_first by exact I|rewrite pair_second]; reflexivity. }
  exists v, w. split.
  - rewrite <- square_pair. rewrite <- form_identity in N |- *. rewrite <- (form_ext (n + n) identity identity v) by
    easy.
    exact N.
  - intros f. rewrite (form_ext _ _ _ v (pair_of n v w) (fun i j _ _ => eq_refl) E), schur_form in R by exact Fit.
    fold f in R. exact R.
Qed.

(** ** Convexity *)

(** [V(sum w_k f_k) <= sum w_k V(f_k)] for weights and a form without negative values. *)
Lemma form_of_mean n P K (w : nat -> R) (f : nat -> vector) :
  (forall v, 0 <= form n P v) -> convex K w ->
  form n P (fun i => sum K (fun k => w k * f k i)) <= sum K (fun k => w k * form n P (f k)).
Proof.
  intros Positive [Weights One]. set (m := (fun i => sum K (fun k => w k * f k i)) : vector).
  assert (S : 0 <= sum K (fun k => w k * form n P (fun i => f k i + -1 * m i))).
  { apply sum_nonnegative. intros k L. apply Rmult_le_pos; [apply Weights, L|apply Positive]. }
  rewrite (sum_ext K _ (fun k => w k * form n P (f k) + (-1) * (w k * bilinear n n P (f k) m)
    + (-1) * (w k * bilinear n n P m (f k)) + w k * form n P m)) in S.
  2: { intros k _. unfold form.
    rewrite (bilinear_plus_left n n P (f k) (fun i => -1 * m i)), bilinear_scale_left.
    rewrite !(bilinear_plus_right n n P _ (f k) (fun i => -1 * m i)), !bilinear_scale_right. ring. }
  rewrite !sum_plus, !sum_times, sum_times_right, One in S.
  rewrite <- (bilinear_sum_left n P K w f m), <- (bilinear_sum_right n P K w f m) in S.
  change (bilinear n n P (fun i => sum K (fun k => w k * f k i)) m) with (form n P m) in S.
  change (bilinear n n P m (fun i => sum K (fun k => w k * f k i))) with (form n P m) in S. fold m. lra.
Qed.

(** ** The statement about trajectories *)

Definition polytope_contracts (n p : nat) (vertices : list vertex) (L P : list (list Q)) (factor lower upper overshoot
  : Q)
  : bool :=
  is_between n P lower upper overshoot &&& Qle_bool 0 factor
    &&& forallb (fun v => shrinks n p (fst v) (snd v) L P factor 0) vertices.

Theorem polytope_error_contracts n p vertices L P factor lower upper overshoot :
  polytope_contracts n p vertices L P factor lower upper overshoot = true ->
  forall (e : nat -> vector) (w : nat -> nat -> R),
  (forall k, convex (length vertices) (w k)) ->
  recursion n e (fun k => hull_error vertices L (w k) (e k)) ->
  (forall k, quadratic n P (e (S k)) <= Q2R factor ^ 2 * quadratic n P (e k))
  /\ (forall k, quadratic n P (e k) <= Q2R factor ^ (2 * k) * quadratic n P (e 0%nat))
  /\ (forall k, norm n (e k) <= Q2R overshoot * Q2R factor ^ k * norm n (e 0%nat)).
Proof.
  intros Checked e w Convex E. apply both in Checked. destruct Checked as [H Shrinks]. apply both in H.
  destruct H as [Between Sign]. apply Qle_bool_iff, Qle_Rle in Sign. rewrite Q2R_zero in Sign.
  assert (HP := is_between_shape _ _ _ _ _ Between).
  destruct (between_numbers _ _ _ _ _ Between) as (Lower & _ & _).
  assert (Semidefinite : forall v, 0 <= form n (real P) v).
  { intros v. apply Rle_trans with (Q2R lower * square n v); [apply Rmult_le_pos; [lra|apply square_nonnegative]|].
    apply (between_lower _ _ _ _ _ Between). }
  apply (falls_at_each_step n P (Q2R factor) lower upper overshoot Between Sign). intros k.
  rewrite !quadratic_form by exact HP. set (K := length vertices) in *. set (v := fun j => nth j vertices ([], [])).
  set (f := fun j => apply n (error_matrix p (fst (v j)) (snd (v j)) L) (e k)).
  assert (Each : forall j, (j < K)%nat -> form n (real P) (f j) <= Q2R factor ^ 2 * form n (real P) (e k)
    /\ forall i, (i < n)%nat -> vertex_error L (v j) (e k) i = f j i).
  { intros j J. rewrite forallb_forall in Shrinks.
    assert (S : shrinks n p (fst (v j)) (snd (v j)) L P factor 0 = true) by (apply Shrinks, nth_In, J).
    pose proof (shrinks_form _ _ _ _ _ _ _ _ S (e k)) as R. rewrite Q2R_zero in R. fold (f j) in R. apply both in S.
    destruct S as [Fit _]. destruct (linear_fits_parts _ _ _ _ _ _ Fit) as (FA & FC & FL & _). split; [lra|].
    intros i I. apply (error_apply n p); try exact I; eapply fits_shape; eassumption. }
  rewrite (form_ext n (real P) (real P) (e (S k)) (fun i => sum K (fun j => w k j * f j i))).
  - apply Rle_trans with (1 := form_of_mean n (real P) K (w k) f Semidefinite (Convex k)).
    destruct (Convex k) as [Weights One].
    apply Rle_trans with (sum K (fun j => w k j * (Q2R factor ^ 2 * form n (real P) (e k)))).
    + apply sum_le. intros j J. apply Rmult_le_compat_l; [apply Weights, J|apply Each, J].
    + rewrite sum_times_right, One. lra.
  - easy.
  - intros i I. rewrite (E k i I). apply sum_ext. intros j J. f_equal. apply Each; assumption.
Qed.
