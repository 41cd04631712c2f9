(** One gain for a polytope of boxes: the theorems [polytope-of-plants] and [polytope-of-jacobians] of certificates with
    entries between bounds.

    (A(t), C(t)) is in the convex hull of boxes: the sum of a pair of each box, with weights that are not negative and
    have the sum 1. The Lyapunov inequality is linear in (A, C): where it holds in every box, it holds on the hull. *)

From Coq Require Import Reals QArith Qreals List Lra Lia.
From Luenberger Require Import Vectors Definite Inequalities Decay LinearObserver Boxes Polytope.
Import ListNotations.
Local Open Scope R_scope.
Local Open Scope lazy_bool_scope.

(** Bounds of the entries of A and of C. *)
Record box : Type := Box { A_low : list (list Q); A_high : list (list Q); C_low : list (list Q); C_high : list (list
  Q) }.

Definition no_box : box := Box [] [] [] [].

(** The pair (A, C) is in the box. *)
Definition in_box (n p : nat) (b : box) (A C : matrix) : Prop :=
  within n n (A_low b) (A_high b) A /\ within p n (C_low b) (C_high b) C.

(** [(A - L C)e] for the sum of the pairs (A_k, C_k) with the weights w. *)
Definition mixed_error (n K : nat) (L : list (list Q)) (w : nat -> R) (A C : nat -> matrix) (e : vector) : vector :=
  fun i => sum K (fun k => w k * (apply n (A k) e - L * apply n (C k) e)%vector i).

Definition boxes_decay (n p : nat) (boxes : list box) (L P : list (list Q)) (a lower upper overshoot : Q) : bool :=
  is_between n P lower upper overshoot
    &&& forallb (fun b => are_ordered n n (A_low b) (A_high b) &&& are_ordered p n (C_low b) (C_high b)
                          &&& falls_within n p (A_low b) (A_high b) (C_low b) (C_high b) L P a 0) boxes.

Theorem boxes_error_decays n p boxes L P a lower upper overshoot :
  boxes_decay n p boxes L P a lower upper overshoot = true ->
  forall (T : R) (e : R -> vector) (w : R -> nat -> R) (A C : R -> nat -> matrix),
  (forall t, convex (length boxes) (w t)) ->
  (forall t k, (k < length boxes)%nat -> in_box n p (nth k boxes no_box) (A t k) (C t k)) ->
  solution T n e (fun t => mixed_error n (length boxes) L (w t) (A t) (C t) (e t)) ->
  (forall s t, 0 <= s -> s <= t -> t < T ->
    quadratic n P (e t) <= exp (- (2 * Q2R a) * (t - s)) * quadratic n P (e s))
  /\ (forall t, 0 <= t -> t < T -> norm n (e t) <= Q2R overshoot * exp (- Q2R a * t) * norm n (e 0)).
Proof.
  intros Checked T e w A C Convex Inside E. apply both in Checked. destruct Checked as [Between Falls].
  assert (HP := is_between_shape _ _ _ _ _ Between). set (K := length boxes) in *.
  assert (Box : forall k, (k < K)%nat -> falls_within n p (A_low (nth k boxes no_box)) (A_high (nth k boxes no_box))
    (C_low (nth k boxes no_box)) (C_high (nth k boxes no_box)) L P a 0 = true).
  { intros k L'. rewrite forallb_forall in Falls. specialize (Falls (nth k boxes no_box) (nth_In _ _ L')).
    apply both in Falls. apply Falls. }
  set (F := fun t k => minus (A t k) (product p (real L) (C t k))).
  set (f := fun t : R => (fun i => sum K (fun k => w t k * apply n (F t k) (e t) i)) : vector).
  assert (S : solution T n e f).
  { apply (solution_ext T n e (fun t => mixed_error n K L (w t) (A t) (C t) (e t))); [|exact E].
    intros t i I. apply sum_ext. intros k L'. f_equal. apply within_apply; [|exact I].
    apply (falls_within_shapes _ _ _ _ _ _ _ _ _ _ (Box k L')). }
  assert (D : forall t, 0 < t < T -> bilinear n n (real P) (f t) (e t) + bilinear n n (real P) (e t) (f t)
    + 2 * Q2R a * form n (real P) (e t) <= 0).
  { intros t _. destruct (Convex t) as [Positive One]. unfold f. rewrite bilinear_sum_left, bilinear_sum_right.
    replace (2 * Q2R a * form n (real P) (e t)) with (sum K (fun k => w t k * (2 * Q2R a * form n (real P) (e t)))).
    2: { rewrite sum_times_right, One. ring. }
    rewrite <- !sum_plus. rewrite <- (sum_zero K). apply sum_le. intros k L'. destruct (Inside t k L') as [InA InC].
    pose proof (falls_within_form _ _ _ _ _ _ _ _ _ _ (Box k L') (A t k) (C t k) InA InC (e t)) as N.
    rewrite lyapunov_form, Q2R_zero in N. specialize (Positive k L'). fold (F t k) in N.
    assert (0 <= w t k * - (bilinear n n (real P) (apply n (F t k) (e t)) (e t)
      + bilinear n n (real P) (e t) (apply n (F t k) (e t)) + 2 * Q2R a * form n (real P) (e t)))
        by (apply Rmult_le_pos; [exact Positive|lra]).
    cbv beta. change (fun i => apply n (F t k) (e t) i) with (apply n (F t k) (e t)). lra. }
  assert (V : forall s t, 0 <= s -> s <= t -> t < T ->
    quadratic n P (e t) <= exp (- (2 * Q2R a) * (t - s)) * quadratic n P (e s)).
  { intros s t Hs Hst Ht. rewrite !quadratic_form by exact HP.
    apply (lyapunov_decay n (real P) (Q2R a) T e f S); assumption. }
  split; [exact V|]. intros t Hs Ht.
  apply (norm_of_form n P lower upper overshoot Between); [apply Rlt_le, exp_pos|].
  specialize (V 0 t (Rle_refl 0) Hs Ht). rewrite !quadratic_form, Rminus_0_r in V by exact HP.
  replace (exp (- Q2R a * t) * exp (- Q2R a * t)) with (exp (- (2 * Q2R a) * t)); [exact V|].
  rewrite <- exp_plus. f_equal. ring.
Qed.
