(** One gain for a polytope of boxes in discrete time: the theorem [discrete-polytope-of-jacobians] of certificates with
    entries between bounds.

    [e(k+1) = (A(k) - L C(k))e(k)] with (A(k), C(k)) in the convex hull of boxes. The form of [[f^2 P, F'P; P F, P]] at
    (v, w) is linear in [F = A - L C]: with the middle F0 of a box and [|F - F0| <= D] it is at least that of F0 less
    [2 |w|'|P| D |v|]. Where it is not negative, [V(F e) <= f^2 V(e)] as at [w = -F e], and V is convex. *)

From Coq Require Import Reals QArith Qreals ZArith List Lra Lia.
From Luenberger Require Import Vectors Definite Inequalities Decay DiscreteObserver Blocks Boxes Polytope BoxPolytope
  DiscretePolytope.
Import ListNotations.
Local Open Scope R_scope.
Local Open Scope lazy_bool_scope.

(** ** The inequality in a box *)

(** [[0, D'|P|; |P| D, 0]] *)
Definition spread_numbers (n : nat) (D P : numbers) : numbers :=
  in_blocks n n no_numbers (times n n n (turned n n D) P) (times n n n P D) no_numbers.

Definition spread_matrix (n : nat) (D P : matrix) : matrix :=
  blocks n nothing (product n (transpose D) P) (product n P D) nothing.

Lemma spread_numbers_correct n D P MD MP :
  equals n n D MD -> equals n n P MP ->
  equals (n + n) (n + n) (spread_numbers n D P) (spread_matrix n MD MP).
Proof.
  intros HD HP. apply in_blocks_correct; try apply no_numbers_correct; apply times_correct; try assumption.
  apply turned_correct, HD.
Qed.

(** What the deviation of F takes at most. *)
Lemma spread_form n P D E (v w : vector) :
  (forall i j, (i < n)%nat -> (j < n)%nat -> Rabs (E i j) <= D i j) ->
  - form (n + n) (spread_matrix n D (magnitude P)) (fun i => Rabs (pair_of n v w i))
    <= bilinear n n P (apply n E v) w + bilinear n n P w (apply n E v).
Proof.
  intros Near. set (a := fun i => Rabs (v i)). set (b := fun i => Rabs (w i)).
  assert (Split : form (n + n) (spread_matrix n D (magnitude P)) (fun i => Rabs (pair_of n v w i))
    = bilinear n n (magnitude P) (apply n D a) b + bilinear n n (magnitude P) b (apply n D a)).
  { rewrite (form_ext (n + n) _ (spread_matrix n D (magnitude P)) _ (pair_of n a b) (fun i j _ _ => eq_refl)).
    - unfold form, spread_matrix. rewrite bilinear_blocks, !bilinear_nothing, bilinear_transpose_product,
      bilinear_product.
      ring.
    - apply each_of_pair; intros i I; [rewrite !pair_first by exact I|rewrite !pair_second]; reflexivity. }
  assert (Large : forall i, (i < n)%nat -> Rabs (apply n E v i) <= apply n D a i).
  { intros i I. apply (deviation_applied n D E v Near i I). }
  assert (Nonnegative : forall i, (i < n)%nat -> 0 <= apply n D a i).
  { intros i I. apply Rle_trans with (2 := Large i I), Rabs_pos. }
  assert (First : Rabs (bilinear n n P (apply n E v) w) <= bilinear n n (magnitude P) (apply n D a) b).
  { apply Rle_trans with (1 := Rabs_sum _ _), sum_le. intros i I. rewrite Rabs_mult.
    apply Rmult_le_compat; try apply Rabs_pos; [apply Large, I|].
    apply Rle_trans with (1 := Rabs_sum _ _), Req_le, sum_ext. intros j _. apply Rabs_mult. }
  assert (Second : Rabs (bilinear n n P w (apply n E v)) <= bilinear n n (magnitude P) b (apply n D a)).
  { apply Rle_trans with (1 := Rabs_sum _ _), sum_le. intros i I. rewrite Rabs_mult.
    apply Rmult_le_compat_l; [apply Rabs_pos|]. apply Rle_trans with (1 := Rabs_sum _ _), sum_le. intros j J.
    rewrite Rabs_mult. apply Rmult_le_compat_l; [apply Rabs_pos|apply Large, J]. }
  rewrite Split. pose proof (Rle_abs (- bilinear n n P (apply n E v) w)) as U.
  pose proof (Rle_abs (- bilinear n n P w (apply n E v))) as U'. rewrite Rabs_Ropp in U, U'. lra.
Qed.

Definition contracts_within (n p : nat) (A_low A_high C_low C_high L P : list (list Q)) (factor q : Q) : bool :=
  fits n n A_low &&& fits n n A_high &&& fits p n C_low &&& fits p n C_high &&& fits n p L &&& fits n n P
    &&& (let G := subtracted (n + n) (n + n)
                    (schur_numbers n (middle_error n p A_low A_high C_low C_high L) (numbers_of n n P) factor)
                    (multiple_of_identity (n + n) q) in
         let R := spread_numbers n (deviation_numbers n p A_low A_high C_low C_high L) (absolute n n (numbers_of n n
           P)) in
         (* Scaled by what is left of the diagonal. *)
         let w := fst (weights (n + n) (table (n + n) (n + n) (fun i j =>
           get (fst G) i j * Zpos (snd R) - Z.abs (get (fst R) i j) * Zpos (snd G))%Z)) in
         all (n + n) (fun i => 0 <? nth i w 0)%Z &&& semidefinite (n + n) (less_spread (n + n) w G R)).

Lemma contracts_within_shapes n p A_low A_high C_low C_high L P factor q :
  contracts_within n p A_low A_high C_low C_high L P factor q = true -> has_shape n p L = true /\ has_shape n n P =
    true.
Proof.
  intros H. apply both in H. destruct H as [H _]. apply both in H. destruct H as [H FP]. apply both in H.
  destruct H as [_ FL]. split; eapply fits_shape; eassumption.
Qed.

Theorem contracts_within_form n p A_low A_high C_low C_high L P factor q :
  contracts_within n p A_low A_high C_low C_high L P factor q = true ->
  forall A C : matrix, within n n A_low A_high A -> within p n C_low C_high C ->
  forall v w, let f := apply n (minus A (product p (real L) C)) v in
  Q2R q * (square n v + square n w)
    <= Q2R factor ^ 2 * form n (real P) v + bilinear n n (real P) f w + bilinear n n (real P) w f + form n (real P) w.
Proof.
  intros H A C HA HC v w f. apply both in H. destruct H as [H K]. apply both in H. destruct H as [H FP]. apply both in
    H.
  destruct H as [H FL]. apply both in H. destruct H as [H FCh]. apply both in H. destruct H as [H FCl]. apply both in H.
  destruct H as [FAl FAh]. cbv zeta in K. apply both in K. destruct K as [W K].
  set (F0 := minus (middle_matrix A_low A_high) (product p (real L) (middle_matrix C_low C_high))).
  set (E := fun i j => minus A (product p (real L) C) i j - F0 i j).
  set (D := deviation p A_low A_high C_low C_high L).
  assert (EF : equals n n (middle_error n p A_low A_high C_low C_high L) F0) by (apply middle_error_correct;
    assumption).
  assert (ED : equals n n (deviation_numbers n p A_low A_high C_low C_high L) D)
    by (apply deviation_correct; assumption).
  assert (Near : forall i j, (i < n)%nat -> (j < n)%nat -> Rabs (E i j) <= D i j)
    by (apply deviation_near; assumption).
  pose proof (less_spread_correct (n + n) _ _ _ _ _ (pair_of n v w) W
    (subtracted_correct _ _ _ _ _ _ (schur_numbers_correct n _ _ factor _ _ EF (fits_equals _ _ _ FP))
      (multiple_of_identity_correct (n + n) q))
    (spread_numbers_correct n _ _ _ _ ED (absolute_correct _ _ _ _ (fits_equals _ _ _ FP))) K) as G.
  pose proof (spread_form n (real P) D E v w Near) as S.
  unfold form in G at 2. rewrite bilinear_minus, bilinear_scale in G.
  fold (form (n + n) identity (pair_of n v w)) in G. rewrite form_identity, square_pair in G.
  unfold schur_matrix in G. rewrite bilinear_blocks, bilinear_scale, bilinear_transpose_product, bilinear_product in G.
  fold (form n (real P) v) (form n (real P) w) in G.
  assert (Flow : forall i, (i < n)%nat -> f i = apply n F0 v i + apply n E v i).
  { intros i _. unfold f. rewrite <- apply_plus. apply apply_ext; [|reflexivity]. intros j _. unfold E, plus. ring. }
  rewrite (bilinear_ext n n (real P) (real P) f w (fun i => apply n F0 v i + apply n E v i) w) by (try exact Flow;
    easy).
  rewrite (bilinear_ext n n (real P) (real P) w f w (fun i => apply n F0 v i + apply n E v i)) by (try exact Flow;
    easy).
  rewrite (bilinear_plus_left n n), (bilinear_plus_right n n).
  change (fun i => apply n E v i) with (apply n E v) in *. change (fun i => apply n F0 v i) with (apply n F0 v) in *.
  lra.
Qed.

(** The fact of a box, with its margin q. *)
Theorem schur_inequality_within n p A_low A_high C_low C_high L P factor q :
  is_positive q &&& contracts_within n p A_low A_high C_low C_high L P factor q = true ->
  0 < Q2R q /\ forall A C : matrix, within n n A_low A_high A -> within p n C_low C_high C ->
  forall v w : vector, let f := (apply n A v - L * apply n C v)%vector in
  Q2R q * (square n v + square n w)
    <= Q2R factor ^ 2 * quadratic n P v + inner n f (P * w)%vector + inner n w (P * f)%vector + quadratic n P w.
Proof.
  intros H. apply both in H. destruct H as [Positive H]. split; [apply is_positive_correct, Positive|].
  intros A C HA HC v w f. destruct (contracts_within_shapes _ _ _ _ _ _ _ _ _ _ H) as [HL HP].
  pose proof (contracts_within_form _ _ _ _ _ _ _ _ _ _ H A C HA HC v w) as K. cbv zeta in K.
  rewrite !inner_bilinear, !quadratic_form by exact HP.
  assert (E : forall i, (i < n)%nat -> f i = apply n (minus A (product p (real L) C)) v i).
  { intros i I. apply within_apply; assumption. }
  rewrite (bilinear_ext n n (real P) (real P) f w _ w (fun i j _ _ => eq_refl) E (fun i _ => eq_refl)).
  rewrite (bilinear_ext n n (real P) (real P) w f w _ (fun i j _ _ => eq_refl) (fun i _ => eq_refl) E). exact K.
Qed.

(** [V(F e) <= factor^2 V(e)] for every F of the box. *)
Lemma box_shrinks n p A_low A_high C_low C_high L P factor A C v :
  contracts_within n p A_low A_high C_low C_high L P factor 0 = true ->
  within n n A_low A_high A -> within p n C_low C_high C ->
  form n (real P) (apply n (minus A (product p (real L) C)) v) <= Q2R factor ^ 2 * form n (real P) v.
Proof.
  intros H HA HC. set (f := apply n (minus A (product p (real L) C)) v).
  pose proof (contracts_within_form _ _ _ _ _ _ _ _ _ _ H A C HA HC v (fun i => -1 * f i)) as K. cbv zeta in K.
  fold f in K. rewrite Q2R_zero, Rmult_0_l, bilinear_scale_right, bilinear_scale_left in K. unfold form in K at 2.
  rewrite bilinear_scale_left, bilinear_scale_right in K. fold (form n (real P) f) in K. lra.
Qed.

(** ** The statement about trajectories *)

Definition boxes_contract (n p : nat) (boxes : list box) (L P : list (list Q)) (factor lower upper overshoot : Q) :
  bool :=
  is_between n P lower upper overshoot &&& Qle_bool 0 factor
    &&& forallb (fun b => are_ordered n n (A_low b) (A_high b) &&& are_ordered p n (C_low b) (C_high b)
                          &&& contracts_within n p (A_low b) (A_high b) (C_low b) (C_high b) L P factor 0) boxes.

Theorem boxes_error_contracts n p boxes L P factor lower upper overshoot :
  boxes_contract n p boxes L P factor lower upper overshoot = true ->
  forall (e : nat -> vector) (w : nat -> nat -> R) (A C : nat -> nat -> matrix),
  (forall k, convex (length boxes) (w k)) ->
  (forall k j, (j < length boxes)%nat -> in_box n p (nth j boxes no_box) (A k j) (C k j)) ->
  recursion n e (fun k => mixed_error n (length boxes) L (w k) (A k) (C k) (e k)) ->
  (forall k, quadratic n P (e (S k)) <= Q2R factor ^ 2 * quadratic n P (e k))
  /\ (forall k, quadratic n P (e k) <= Q2R factor ^ (2 * k) * quadratic n P (e 0%nat))
  /\ (forall k, norm n (e k) <= Q2R overshoot * Q2R factor ^ k * norm n (e 0%nat)).
Proof.
  intros Checked e w A C Convex Inside E. apply both in Checked. destruct Checked as [H Contract]. apply both in H.
  destruct H as [Between Sign]. apply Qle_bool_iff, Qle_Rle in Sign. rewrite Q2R_zero in Sign.
  assert (HP := is_between_shape _ _ _ _ _ Between).
  destruct (between_numbers _ _ _ _ _ Between) as (Lower & _ & _).
  assert (Semidefinite : forall v, 0 <= form n (real P) v).
  { intros v. apply Rle_trans with (Q2R lower * square n v); [apply Rmult_le_pos; [lra|apply square_nonnegative]|].
    apply (between_lower _ _ _ _ _ Between). }
  apply (falls_at_each_step n P (Q2R factor) lower upper overshoot Between Sign). intros k.
  rewrite !quadratic_form by exact HP. set (K := length boxes) in *.
  set (f := fun j => apply n (minus (A k j) (product p (real L) (C k j))) (e k)).
  assert (Each : forall j, (j < K)%nat -> form n (real P) (f j) <= Q2R factor ^ 2 * form n (real P) (e k)
    /\ forall i, (i < n)%nat -> (apply n (A k j) (e k) - L * apply n (C k j) (e k))%vector i = f j i).
  { intros j J. rewrite forallb_forall in Contract. specialize (Contract (nth j boxes no_box) (nth_In _ _ J)).
    apply both in Contract. destruct Contract as [_ W]. destruct (Inside k j J) as [InA InC]. split.
    - apply (box_shrinks _ _ _ _ _ _ _ _ _ _ _ _ W InA InC).
    - intros i I. apply within_apply; [|exact I]. apply (contracts_within_shapes _ _ _ _ _ _ _ _ _ _ W). }
  rewrite (form_ext n (real P) (real P) (e (S k)) (fun i => sum K (fun j => w k j * f j i))).
  - apply Rle_trans with (1 := form_of_mean n (real P) K (w k) f Semidefinite (Convex k)).
    destruct (Convex k) as [Weights One].
    apply Rle_trans with (sum K (fun j => w k j * (Q2R factor ^ 2 * form n (real P) (e k)))).
    + apply sum_le. intros j J. apply Rmult_le_compat_l; [apply Weights, J|apply Each, J].
    + rewrite sum_times_right, One. lra.
  - easy.
  - intros i I. rewrite (E k i I). apply sum_ext. intros j J. f_equal. apply Each; assumption.
Qed.
