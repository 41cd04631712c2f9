(** Data between bounds, refuted: matrices A and C between them, and a vector at which the form has the wrong sign. *)

From Coq Require Import Reals QArith Qreals ZArith List Lra Lia.
From Luenberger Require Import Vectors Definite Inequalities Boxes DiscretePolytope Refuted.
Import ListNotations.
Local Open Scope R_scope.
Local Open Scope lazy_bool_scope.

(** [low <= M <= high], entry by entry. *)
Definition is_within (n m : nat) (low high M : list (list Q)) : bool :=
  all n (fun i => all m (fun j => Qle_bool (entry low i j) (entry M i j) &&& Qle_bool (entry M i j) (entry high i j))).

Lemma is_within_correct n m low high M : is_within n m low high M = true -> within n m low high (real M).
Proof.
  intros H i j I J. apply (all_correct _ _ i) in H; [|exact I]. apply (all_correct _ _ j) in H; [|exact J].
  apply both in H. destruct H as [Low High].
  apply Qle_bool_iff, Qle_Rle in Low. apply Qle_bool_iff, Qle_Rle in High. split; assumption.
Qed.

(** The matrices of the certificate as matrices of real numbers. *)
Lemma error_of_lists n p A C L (v : vector) i :
  has_shape n n A = true -> has_shape p n C = true -> has_shape n p L = true -> (i < n)%nat ->
  (A * v - L * (C * v))%vector i = (apply n (real A) v - L * apply n (real C) v)%vector i.
Proof.
  intros HA HC HL I. unfold minus_vector. rewrite (times_vector_apply n n A), !(times_vector_apply n p L) by assumption.
  f_equal. apply apply_ext; [reflexivity|]. intros j J. apply (times_vector_apply p n C); assumption.
Qed.

(** [F'P + PF + 2 rate P] is not negative definite for A and C between the bounds. *)
Theorem no_lyapunov_inequality_within n p A_low A_high C_low C_high L P rate A C v :
  is_within n n A_low A_high A &&& is_within p n C_low C_high C
    &&& (linear_fits n p A C L P
      &&& is_witness false n (negative n n (lyapunov_numbers n (error_numbers n p A C L) (numbers_of n n P) rate))
        v) = true ->
  exists A C : matrix, within n n A_low A_high A /\ within p n C_low C_high C /\
  exists v : vector, 0 < square n v /\
    let w := (apply n A v - L * apply n C v)%vector in
    0 <= inner n w (P * v)%vector + inner n v (P * w)%vector + 2 * Q2R rate * quadratic n P v.
Proof.
  intros H. apply both in H. destruct H as [H Witness]. apply both in H. destruct H as [InA InC].
  exists (real A), (real C). split; [apply is_within_correct, InA|]. split; [apply is_within_correct, InC|].
  destruct (no_lyapunov_inequality n p A C L P rate v Witness) as (x & Positive & Sign).
  exists x. split; [exact Positive|]. apply both in Witness. destruct Witness as [Fit _].
  destruct (linear_fits_parts _ _ _ _ _ _ Fit) as (FA & FC & FL & FP).
  pose proof (fits_shape _ _ _ FP) as HP. cbv zeta in *. rewrite !inner_bilinear in * by exact HP.
  assert (E : forall i, (i < n)%nat ->
    (A * x - L * (C * x))%vector i = (apply n (real A) x - L * apply n (real C) x)%vector i).
  { intros i I. apply (error_of_lists n p); try exact I; eapply fits_shape; eassumption. }
  rewrite <- (bilinear_ext n n (real P) (real P) _ x _ x (fun i j _ _ => eq_refl) E (fun i _ => eq_refl)).
  rewrite <- (bilinear_ext n n (real P) (real P) x _ x _ (fun i j _ _ => eq_refl) (fun i _ => eq_refl) E). exact Sign.
Qed.

(** [[factor^2 P, F'P; P F, P]] is not positive definite for A and C between the bounds. *)
Theorem no_schur_inequality_within n p A_low A_high C_low C_high L P factor A C z :
  is_within n n A_low A_high A &&& is_within p n C_low C_high C
    &&& (linear_fits n p A C L P
      &&& is_witness false (n + n) (schur_numbers n (error_numbers n p A C L) (numbers_of n n P) factor) z) = true ->
  exists A C : matrix, within n n A_low A_high A /\ within p n C_low C_high C /\
  exists v w : vector, 0 < square n v + square n w /\
    let f := (apply n A v - L * apply n C v)%vector in
    Q2R factor ^ 2 * quadratic n P v + inner n f (P * w)%vector + inner n w (P * f)%vector + quadratic n P w <= 0.
Proof.
  intros H. apply both in H. destruct H as [H Witness]. apply both in H. destruct H as [InA InC].
  exists (real A), (real C). split; [apply is_within_correct, InA|]. split; [apply is_within_correct, InC|].
  destruct (no_schur_inequality n p A C L P factor z Witness) as (x & y & Positive & Sign).
  exists x, y. split; [exact Positive|]. apply both in Witness. destruct Witness as [Fit _].
  destruct (linear_fits_parts _ _ _ _ _ _ Fit) as (FA & FC & FL & FP).
  pose proof (fits_shape _ _ _ FP) as HP. cbv zeta in *. rewrite !inner_bilinear in * by exact HP.
  assert (E : forall i, (i < n)%nat ->
    (A * x - L * (C * x))%vector i = (apply n (real A) x - L * apply n (real C) x)%vector i).
  { intros i I. apply (error_of_lists n p); try exact I; eapply fits_shape; eassumption. }
  rewrite <- (bilinear_ext n n (real P) (real P) _ y _ y (fun i j _ _ => eq_refl) E (fun i _ => eq_refl)).
  rewrite <- (bilinear_ext n n (real P) (real P) y _ y _ (fun i j _ _ => eq_refl) (fun i _ => eq_refl) E). exact Sign.
Qed.
