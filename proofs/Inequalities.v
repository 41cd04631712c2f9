(** The matrix inequalities of certificates, decided by [vm_compute] and stated for vectors of real numbers. *)

From Coq Require Import Reals QArith Qreals ZArith List Lra Lia.
From Luenberger Require Import Vectors Definite.
Import ListNotations.
Local Open Scope R_scope.
Local Open Scope lazy_bool_scope.


(** [A - L C] *)
Definition error_numbers (n p : nat) (A C L : list (list Q)) : numbers :=
  shortened n n (subtracted n n (numbers_of n n A) (times n p n (numbers_of n p L) (numbers_of p n C))).

(** [F'P + P F + 2 a P] *)
Definition lyapunov_numbers (n : nat) (F P : numbers) (a : Q) : numbers :=
  let PF := times n n n P F in
  shortened n n (added n n (added n n (times n n n (turned n n F) P) PF) (multiple n n (2 * a) P)).

Definition error_matrix (p : nat) (A C L : list (list Q)) : matrix :=
  minus (real A) (product p (real L) (real C)).

Definition lyapunov_matrix (n : nat) (F P : matrix) (a : R) : matrix :=
  plus (plus (product n (transpose F) P) (product n P F)) (scale (2 * a) P).

(** The matrices have their shapes, and over their denominators they are what they were. *)
Definition fits (n m : nat) (A : list (list Q)) : bool := has_shape n m A &&& are_exact n m A (numbers_of n m A).

Lemma fits_shape n m A : fits n m A = true -> has_shape n m A = true.
Proof. intros H. apply both in H. apply H. Qed.

Lemma fits_equals n m A : fits n m A = true -> equals n m (numbers_of n m A) (real A).
Proof. intros H. apply both in H. apply are_exact_correct, H. Qed.

Definition linear_fits (n p : nat) (A C L P : list (list Q)) : bool :=
  fits n n A &&& fits p n C &&& fits n p L &&& fits n n P.

Lemma linear_fits_parts n p A C L P :
  linear_fits n p A C L P = true -> fits n n A = true /\ fits p n C = true /\ fits n p L = true /\ fits n n P = true.
Proof. unfold linear_fits. destruct (fits n n A), (fits p n C), (fits n p L), (fits n n P); easy. Qed.

Lemma error_numbers_correct n p A C L :
  fits n n A = true -> fits p n C = true -> fits n p L = true ->
  equals n n (error_numbers n p A C L) (error_matrix p A C L).
Proof.
  intros HA HC HL. apply shortened_correct, subtracted_correct; [apply fits_equals, HA|].
  apply times_correct; apply fits_equals; assumption.
Qed.

Lemma two_times a : Q2R (2 * a) = 2 * Q2R a.
Proof. rewrite Q2R_mult. f_equal. unfold Q2R. simpl. lra. Qed.

Lemma lyapunov_numbers_correct n F P a MF MP :
  equals n n F MF -> equals n n P MP -> equals n n (lyapunov_numbers n F P a) (lyapunov_matrix n MF MP (Q2R a)).
Proof.
  intros HF HP. unfold lyapunov_matrix. rewrite <- two_times. unfold lyapunov_numbers.
  apply shortened_correct, added_correct; [apply added_correct|].
  - apply times_correct; [apply turned_correct|]; assumption.
  - apply times_correct; assumption.
  - apply multiple_correct. assumption.
Qed.

(** [v'(F'P + PF + 2 a P)v] *)
Lemma lyapunov_form n F P a v :
  form n (lyapunov_matrix n F P a) v
  = bilinear n n P (apply n F v) v + bilinear n n P v (apply n F v) + 2 * a * form n P v.
Proof.
  unfold form, lyapunov_matrix. rewrite !bilinear_plus, bilinear_scale, bilinear_transpose_product, bilinear_product.
    reflexivity.
Qed.

(** [F v], with the matrices of the certificate. *)
Lemma error_apply n p A C L (v : vector) i :
  has_shape n n A = true -> has_shape p n C = true -> has_shape n p L = true -> (i < n)%nat ->
  (A * v - L * (C * v))%vector i = apply n (error_matrix p A C L) v i.
Proof.
  intros HA HC HL I. unfold error_matrix, minus_vector. rewrite apply_minus, apply_product.
  rewrite (times_vector_apply n n), (times_vector_apply n p) by assumption. f_equal.
  apply apply_ext; [reflexivity|]. intros j J. apply (times_vector_apply p); assumption.
Qed.

(** What plant and observer do to the error, whatever the input. *)
Lemma difference_of_right_sides n p A B C L (u x xhat : vector) i :
  has_shape n n A = true -> has_shape p n C = true -> has_shape n p L = true -> (i < n)%nat ->
  (A * x + B * u)%vector i - (A * xhat + B * u + L * (C * x - C * xhat))%vector i
  = (A * (x - xhat) - L * (C * (x - xhat)))%vector i.
Proof.
  intros HA HC HL I. unfold plus_vector, minus_vector.
  rewrite !(times_vector_apply n n A) by assumption. rewrite !(times_vector_apply n p L) by assumption.
  rewrite (apply_ext p (real L) (real L) (times_vector C (fun j => x j - xhat j))
             (fun j => (C * x)%vector j - (C * xhat)%vector j) i); try reflexivity.
  - rewrite !apply_minus_vector. ring.
  - intros j J. rewrite !(times_vector_apply p n C) by assumption. apply apply_minus_vector.
Qed.

Definition is_positive (q : Q) : bool := (0 <? Qnum q)%Z.

Lemma is_positive_correct q : is_positive q = true -> 0 < Q2R q.
Proof.
  intros H. apply Z.ltb_lt, IZR_lt in H. unfold Q2R. apply Rmult_lt_0_compat; [exact H|].
  apply Rinv_0_lt_compat, IZR_lt. reflexivity.
Qed.

(** [M >= q I] *)
Definition is_at_least (n : nat) (M : list (list Q)) (q : Q) : bool := fits n n M &&& at_least n (numbers_of n n M) q.

Theorem is_at_least_correct n M q :
  is_at_least n M q = true -> forall v, Q2R q * square n v <= quadratic n M v.
Proof.
  intros H v. apply both in H. destruct H as [F H]. rewrite quadratic_form by apply (fits_shape _ _ _ F).
  apply (at_least_correct _ _ _ _ (fits_equals _ _ _ F) H).
Qed.

(** The fact [M > 0] of certificates, with its margin q. *)
Theorem positive_definite n M q :
  is_positive q &&& is_at_least n M q = true -> 0 < Q2R q /\ forall v, Q2R q * square n v <= quadratic n M v.
Proof.
  intros H. apply both in H. destruct H as [Positive H]. split; [apply is_positive_correct, Positive|].
  apply is_at_least_correct, H.
Qed.

(** [F'P + PF + 2 rate P <= - q I] *)
Definition falls (n p : nat) (A C L P : list (list Q)) (rate q : Q) : bool :=
  linear_fits n p A C L P
    &&& at_least n (negative n n (lyapunov_numbers n (error_numbers n p A C L) (numbers_of n n P) rate)) q.

Lemma falls_form n p A C L P rate q :
  falls n p A C L P rate q = true ->
  forall v, form n (lyapunov_matrix n (error_matrix p A C L) (real P) (Q2R rate)) v <= - Q2R q * square n v.
Proof.
  intros H v. apply both in H. destruct H as [Fit H]. destruct (linear_fits_parts _ _ _ _ _ _ Fit)
    as (FA & FC & FL & FP).
  pose proof (at_least_correct _ _ _ _ (negative_correct _ _ _ _ (lyapunov_numbers_correct _ _ _ rate _ _
    (error_numbers_correct _ _ _ _ _ FA FC FL) (fits_equals _ _ _ FP))) H v) as K.
  unfold form in K at 1. rewrite bilinear_scale in K. unfold form. lra.
Qed.

(** [F v], with the matrices of the certificate, in a form. *)
Lemma lyapunov_quadratic n p A C L P rate (v : vector) :
  linear_fits n p A C L P = true ->
  let w := (A * v - L * (C * v))%vector in
  inner n w (P * v)%vector + inner n v (P * w)%vector + 2 * rate * quadratic n P v
  = form n (lyapunov_matrix n (error_matrix p A C L) (real P) rate) v.
Proof.
  intros Fit w. destruct (linear_fits_parts _ _ _ _ _ _ Fit) as (FA & FC & FL & FP). rewrite lyapunov_form.
  rewrite !inner_bilinear, quadratic_form by apply (fits_shape _ _ _ FP).
  assert (W : forall i, (i < n)%nat -> w i = apply n (error_matrix p A C L) v i).
  { intros i I. apply (error_apply n p); try assumption; eapply fits_shape; eassumption. }
  rewrite (bilinear_ext n n (real P) (real P) w v (apply n (error_matrix p A C L) v) v),
    (bilinear_ext n n (real P) (real P) v w v (apply n (error_matrix p A C L) v)); easy.
Qed.

(** The fact (12) of certificates, [F'P + PF + 2 rate P < 0], with its margin q. *)
Theorem lyapunov_inequality n p A C L P rate q :
  is_positive q &&& falls n p A C L P rate q = true ->
  0 < Q2R q /\ forall v : vector, let w := (A * v - L * (C * v))%vector in
  inner n w (P * v)%vector + inner n v (P * w)%vector + 2 * Q2R rate * quadratic n P v <= - Q2R q * square n v.
Proof.
  intros H. apply both in H. destruct H as [Positive H]. split; [apply is_positive_correct, Positive|].
  intros v. pose proof (falls_form _ _ _ _ _ _ _ _ H v) as K. apply both in H. destruct H as [Fit _].
  rewrite <- lyapunov_quadratic in K by exact Fit. exact K.
Qed.

(** [F'P F - factor^2 P <= - q I]: the second fact of [discrete-observer]. *)
Definition stein_numbers (n : nat) (F P : numbers) (factor : Q) : numbers :=
  subtracted n n (times n n n (turned n n F) (times n n n P F)) (multiple n n (factor * factor) P).

Definition stein_matrix (n : nat) (F P : matrix) (factor : R) : matrix :=
  minus (product n (transpose F) (product n P F)) (scale (factor * factor) P).

Lemma stein_numbers_correct n F P factor MF MP :
  equals n n F MF -> equals n n P MP -> equals n n (stein_numbers n F P factor) (stein_matrix n MF MP (Q2R factor)).
Proof.
  intros HF HP. unfold stein_matrix. rewrite <- Q2R_mult. unfold stein_numbers.
  apply subtracted_correct; [apply times_correct; [apply turned_correct|apply times_correct]; assumption|].
  apply multiple_correct. assumption.
Qed.

Lemma stein_form n F P factor v :
  form n (stein_matrix n F P factor) v = form n P (apply n F v) - factor * factor * form n P v.
Proof.
  unfold form, stein_matrix. rewrite bilinear_minus, bilinear_scale, bilinear_transpose_product. f_equal.
  unfold bilinear. apply sum_ext. intros i _. f_equal. apply apply_product.
Qed.

Definition shrinks (n p : nat) (A C L P : list (list Q)) (factor q : Q) : bool :=
  linear_fits n p A C L P
    &&& at_least n (negative n n (stein_numbers n (error_numbers n p A C L) (numbers_of n n P) factor)) q.

Lemma shrinks_form n p A C L P factor q :
  shrinks n p A C L P factor q = true ->
  forall v, form n (real P) (apply n (error_matrix p A C L) v) - Q2R factor * Q2R factor * form n (real P) v
            <= - Q2R q * square n v.
Proof.
  intros H v. apply both in H. destruct H as [Fit H]. destruct (linear_fits_parts _ _ _ _ _ _ Fit)
    as (FA & FC & FL & FP).
  pose proof (at_least_correct _ _ _ _ (negative_correct _ _ _ _ (stein_numbers_correct _ _ _ factor _ _
    (error_numbers_correct _ _ _ _ _ FA FC FL) (fits_equals _ _ _ FP))) H v) as K.
  unfold form in K at 1. rewrite bilinear_scale in K. fold (form n (stein_matrix n (error_matrix p A C L) (real P)
    (Q2R factor)) v) in K.
  rewrite stein_form in K. lra.
Qed.

Lemma stein_quadratic n p A C L P factor (v : vector) :
  linear_fits n p A C L P = true ->
  let w := (A * v - L * (C * v))%vector in
  quadratic n P w - factor ^ 2 * quadratic n P v = form n (stein_matrix n (error_matrix p A C L) (real P) factor) v.
Proof.
  intros Fit w. destruct (linear_fits_parts _ _ _ _ _ _ Fit) as (FA & FC & FL & FP). rewrite stein_form.
  rewrite !quadratic_form by apply (fits_shape _ _ _ FP).
  rewrite (form_ext n (real P) (real P) w (apply n (error_matrix p A C L) v)); [ring|easy|].
  intros i I. apply (error_apply n p); try assumption; eapply fits_shape; eassumption.
Qed.

(** The second fact of [discrete-observer], [F'P F - factor^2 P < 0], with its margin q. *)
Theorem stein_inequality n p A C L P factor q :
  is_positive q &&& shrinks n p A C L P factor q = true ->
  0 < Q2R q /\ forall v : vector, let w := (A * v - L * (C * v))%vector in
  quadratic n P w - Q2R factor ^ 2 * quadratic n P v <= - Q2R q * square n v.
Proof.
  intros H. apply both in H. destruct H as [Positive H]. split; [apply is_positive_correct, Positive|].
  intros v w. pose proof (shrinks_form _ _ _ _ _ _ _ _ H v) as K. rewrite <- stein_form in K.
  apply both in H. destruct H as [Fit _]. unfold w. rewrite (stein_quadratic n p) by exact Fit. exact K.
Qed.

(** [lower I <= P <= upper I], [0 < lower] and [upper <= overshoot^2 lower]: of a [V = e'Pe] that is bounded, the norm
    of e is bounded. *)
Definition is_between (n : nat) (P : list (list Q)) (lower upper overshoot : Q) : bool :=
  (negb (Qle_bool lower 0) &&& Qle_bool 0 overshoot &&& Qle_bool upper (overshoot * overshoot * lower))
    &&& is_at_least n P lower
    &&& at_least n (negative n n (numbers_of n n P)) (- upper).

Lemma Q2R_zero : Q2R 0 = 0.
Proof. unfold Q2R. simpl. lra. Qed.

Lemma is_between_shape n P lower upper overshoot : is_between n P lower upper overshoot = true ->
  has_shape n n P = true.
Proof.
  intros H. apply both in H. destruct H as [H _]. apply both in H. destruct H as [_ H]. apply both in H.
  apply fits_shape, H.
Qed.

(** [lower s <= V <= c^2 W] and [W <= upper r] imply [sqrt s <= overshoot c sqrt r]. *)
Lemma root_of_bound lower upper overshoot c V W s r :
  0 < lower -> 0 <= overshoot -> upper <= overshoot * overshoot * lower -> 0 <= c -> 0 <= s -> 0 <= r ->
  lower * s <= V -> V <= c * c * W -> W <= upper * r -> sqrt s <= overshoot * c * sqrt r.
Proof.
  intros Positive Sign Big Hc Hs Hr Low K High.
  rewrite <- (sqrt_square (overshoot * c)) by (apply Rmult_le_pos; assumption).
  rewrite <- sqrt_mult; [|apply Rle_0_sqr|exact Hr]. apply sqrt_le_1; [exact Hs|apply Rmult_le_pos; [apply Rle_0_sqr|
    exact Hr]|].
  apply Rmult_le_reg_l with lower; [exact Positive|].
  apply Rle_trans with (c * c * (upper * r)).
  - apply Rle_trans with (1 := Low), Rle_trans with (1 := K). apply Rmult_le_compat_l; [apply Rle_0_sqr|exact High].
  - replace (lower * (overshoot * c * (overshoot * c) * r)) with (c * c * (overshoot * overshoot * lower * r)) by ring.
    apply Rmult_le_compat_l; [apply Rle_0_sqr|]. apply Rmult_le_compat_r; assumption.
Qed.

Section Between.
  Variables (n : nat) (P : list (list Q)) (lower upper overshoot : Q).
  Hypothesis Checked : is_between n P lower upper overshoot = true.

  Lemma between_lower v : Q2R lower * square n v <= form n (real P) v.
  Proof.
    rewrite <- quadratic_form by apply (is_between_shape _ _ _ _ _ Checked). apply is_at_least_correct.
    apply both in Checked. destruct Checked as [H _]. apply both in H. apply H.
  Qed.

  Lemma between_upper v : form n (real P) v <= Q2R upper * square n v.
  Proof.
    pose proof (both _ _ Checked) as [H Upper]. pose proof (both _ _ H) as [_ Lower]. pose proof (both _ _ Lower)
      as [Fit _].
    pose proof (at_least_correct _ _ _ _ (negative_correct _ _ _ _ (fits_equals _ _ _ Fit)) Upper v) as K.
    unfold form in K at 1. rewrite bilinear_scale, Q2R_opp in K. unfold form. lra.
  Qed.

  Lemma between_numbers :
    0 < Q2R lower /\ 0 <= Q2R overshoot /\ Q2R upper <= Q2R overshoot * Q2R overshoot * Q2R lower.
  Proof.
    pose proof (both _ _ Checked) as [H _]. pose proof (both _ _ H) as [K _].
    pose proof (both _ _ K) as [K' Big]. pose proof (both _ _ K') as [Positive Sign]. repeat split.
    - apply Bool.negb_true_iff in Positive. apply Rnot_le_lt. intros N. rewrite <- Q2R_zero in N.
      apply Rle_Qle, Qle_bool_iff in N. congruence.
    - apply Qle_bool_iff, Qle_Rle in Sign. rewrite Q2R_zero in Sign. exact Sign.
    - apply Qle_bool_iff, Qle_Rle in Big. rewrite !Q2R_mult in Big. exact Big.
  Qed.

  (** [V(e) <= c^2 V(d)] implies [|e| <= overshoot c |d|]. *)
  Lemma norm_of_form c (e d : vector) :
    0 <= c -> form n (real P) e <= c * c * form n (real P) d -> norm n e <= Q2R overshoot * c * norm n d.
  Proof.
    intros Hc K. destruct between_numbers as (Positive & Sign & Big).
    apply (root_of_bound _ _ _ _ (form n (real P) e) (form n (real P) d) _ _ Positive Sign Big Hc);
      try apply square_nonnegative; try apply between_lower; try apply between_upper. exact K.
  Qed.
End Between.
