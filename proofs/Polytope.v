(** One gain for a polytope of linear plants: the theorem [polytope-of-plants] of certificates.

    [e' = (A(t) - L C(t))e] with (A(t), C(t)) in the convex hull of vertices (A_k, C_k), fixed or varying in time. The
    Lyapunov inequality is linear in (A, C): where it holds at the vertices, it holds on the hull. *)

From Coq Require Import Reals QArith Qreals List Lra Lia.
From Luenberger Require Import Vectors Definite Inequalities Decay LinearObserver.
Import ListNotations.
Local Open Scope R_scope.
Local Open Scope lazy_bool_scope.

Definition vertex : Type := list (list Q) * list (list Q).

(** [(A_k - L C_k)e] *)
Definition vertex_error (L : list (list Q)) (v : vertex) (e : vector) : vector :=
  (fst v * e - L * (snd v * e))%vector.

(** [(A - L C)e] for the sum of the vertices with the weights w. *)
Definition hull_error (vertices : list vertex) (L : list (list Q)) (w : nat -> R) (e : vector) : vector :=
  fun i => sum (length vertices) (fun k => w k * vertex_error L (nth k vertices ([], [])) e i).

(** Weights of a point of the hull. *)
Definition convex (K : nat) (w : nat -> R) : Prop := (forall k, (k < K)%nat -> 0 <= w k) /\ sum K w = 1.

Definition polytope_decays (n p : nat) (vertices : list vertex) (L P : list (list Q)) (a lower upper overshoot : Q)
  : bool :=
  is_between n P lower upper overshoot &&& forallb (fun v => falls n p (fst v) (snd v) L P a 0) vertices.

(** The inequality at each vertex, with its margin: facts of certificates. *)
Definition falls_at (n p : nat) (vertices : list vertex) (L P : list (list Q)) (rate : Q) (k : nat) (q : Q) : bool :=
  falls n p (fst (nth k vertices ([], []))) (snd (nth k vertices ([], []))) L P rate q.

Lemma bilinear_sum_left n M K (w : nat -> R) (f : nat -> vector) x :
  bilinear n n M (fun i => sum K (fun k => w k * f k i)) x = sum K (fun k => w k * bilinear n n M (f k) x).
Proof.
  induction K as [|K IH].
  - unfold bilinear. simpl. rewrite (sum_ext n _ (fun _ => 0)); [apply sum_zero|intros; ring].
  - simpl. rewrite (bilinear_plus_left n n M (fun i => sum K (fun k => w k * f k i)) (fun i => w K * f K i)), IH.
    rewrite bilinear_scale_left. reflexivity.
Qed.

Lemma bilinear_sum_right n M K (w : nat -> R) (f : nat -> vector) x :
  bilinear n n M x (fun i => sum K (fun k => w k * f k i)) = sum K (fun k => w k * bilinear n n M x (f k)).
Proof.
  rewrite <- (bilinear_transpose n n M), bilinear_sum_left. apply sum_ext. intros k _.
  rewrite bilinear_transpose. reflexivity.
Qed.

Theorem polytope_error_decays n p vertices L P a lower upper overshoot :
  polytope_decays n p vertices L P a lower upper overshoot = true ->
  forall (T : R) (e : R -> vector) (w : R -> nat -> R),
  (forall t, convex (length vertices) (w t)) ->
  solution T n e (fun t => hull_error vertices L (w t) (e t)) ->
  (forall s t, 0 <= s -> s <= t -> t < T ->
    quadratic n P (e t) <= exp (- (2 * Q2R a) * (t - s)) * quadratic n P (e s))
  /\ (forall t, 0 <= t -> t < T -> norm n (e t) <= Q2R overshoot * exp (- Q2R a * t) * norm n (e 0)).
Proof.
  intros Checked T e w Convex E. apply both in Checked. destruct Checked as [Between Falls].
  assert (HP := is_between_shape _ _ _ _ _ Between).
  set (K := length vertices) in *. set (v := fun k => nth k vertices ([], [])).
  assert (Vertex : forall k, (k < K)%nat -> falls n p (fst (v k)) (snd (v k)) L P a 0 = true).
  { intros k L'. rewrite forallb_forall in Falls. apply Falls, nth_In. exact L'. }
  set (F := fun k => error_matrix p (fst (v k)) (snd (v k)) L).
  set (f := fun t : R => (fun i => sum K (fun k => w t k * apply n (F k) (e t) i)) : vector).
  assert (S : solution T n e f).
  { apply (solution_ext T n e (fun t => hull_error vertices L (w t) (e t))); [|exact E].
    intros t i I. apply sum_ext. intros k L'. f_equal. specialize (Vertex k L').
    apply both in Vertex. destruct Vertex as [Fit _]. destruct (linear_fits_parts _ _ _ _ _ _ Fit)
      as (FA & FC & FL & _).
    apply (error_apply n p); try assumption; eapply fits_shape; eassumption. }
  assert (D : forall t, 0 < t < T -> bilinear n n (real P) (f t) (e t) + bilinear n n (real P) (e t) (f t)
    + 2 * Q2R a * form n (real P) (e t) <= 0).
  { intros t _. destruct (Convex t) as [Positive One]. unfold f. rewrite bilinear_sum_left, bilinear_sum_right.
    replace (2 * Q2R a * form n (real P) (e t)) with (sum K (fun k => w t k * (2 * Q2R a * form n (real P) (e t)))).
    2: { rewrite sum_times_right, One. ring. }
    rewrite <- !sum_plus. rewrite <- (sum_zero K). apply sum_le. intros k L'.
    pose proof (falls_form _ _ _ _ _ _ _ _ (Vertex k L') (e t)) as N. rewrite lyapunov_form, Q2R_zero in N.
    specialize (Positive k L'). fold (F k) in N.
    assert (0 <= w t k * - (bilinear n n (real P) (apply n (F k) (e t)) (e t)
      + bilinear n n (real P) (e t) (apply n (F k) (e t)) + 2 * Q2R a * form n (real P) (e t)))
        by (apply Rmult_le_pos; [exact Positive|lra]).
    cbv beta. change (fun i => apply n (F k) (e t) i) with (apply n (F k) (e t)). lra. }
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
