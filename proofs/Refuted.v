(** Refuted inequalities: a vector v, not 0, for which [v'Mv] has the wrong sign. *)

From Coq Require Import Reals QArith Qreals ZArith List Lra Lia.
From Luenberger Require Import Vectors Definite Inequalities.
Import ListNotations.
Local Open Scope R_scope.
Local Open Scope lazy_bool_scope.

(** A column of numbers as a vector. *)
Definition column (v : list (list Q)) : vector := fun i => real v i 0%nat.

(** [v'Mv], over a denominator. *)
Definition form_at (n : nat) (M v : numbers) : numbers := times 1 n 1 (turned 1 n v) (times n n 1 M v).

Lemma form_at_correct n X M v V :
  equals n n X M -> equals n 1 v (real V) -> value (form_at n X v) 0%nat 0%nat = form n M (column V).
Proof.
  intros HX Hv.
  apply (times_correct 1 n 1 _ _ _ _ (turned_correct 1 n _ _ Hv) (times_correct n n 1 _ _ _ _ HX Hv) 0 0)%nat; lia.
Qed.

Definition sign_at (n : nat) (M v : numbers) : Z := Z.sgn (get (fst (form_at n M v)) 0 0).

Lemma sign_at_correct n X M v V :
  equals n n X M -> equals n 1 v (real V) ->
  (sign_at n X v = 1%Z -> 0 < form n M (column V)) /\ (sign_at n X v <> 1%Z -> form n M (column V) <= 0)
  /\ (sign_at n X v = (-1)%Z -> form n M (column V) < 0).
Proof.
  intros HX Hv. rewrite <- (form_at_correct n X M v V HX Hv). unfold sign_at, value.
  pose proof (denominator_positive (form_at n X v)) as D. apply Rinv_0_lt_compat in D.
  set (z := get (fst (form_at n X v)) 0 0). unfold Rdiv. set (d := / IZR (Zpos (snd (form_at n X v)))) in *.
  repeat split; intros H.
  - apply Z.sgn_pos_iff, IZR_lt in H. apply Rmult_lt_0_compat; assumption.
  - assert (K : (z <= 0)%Z). { destruct (Z.le_gt_cases z 0); [assumption|]. exfalso. apply H, Z.sgn_pos_iff. lia. }
    apply IZR_le in K. assert (IZR z * d <= 0 * d) by (apply Rmult_le_compat_r; lra). lra.
  - apply Z.sgn_neg_iff, IZR_lt in H. assert (IZR z * d < 0 * d) by (apply Rmult_lt_compat_r; lra). lra.
Qed.

(** v is not 0, and [v'Mv <= 0]; with [strict], [v'Mv < 0]. *)
Definition is_witness (strict : bool) (n : nat) (M : numbers) (v : list (list Q)) : bool :=
  are_exact n 1 v (numbers_of n 1 v)
    &&& (sign_at n (multiple_of_identity n 1) (numbers_of n 1 v) =? 1)%Z
    &&& (if strict then (sign_at n M (numbers_of n 1 v) =? -1)%Z else negb (sign_at n M (numbers_of n 1 v) =? 1)%Z).

Lemma is_witness_correct strict n X M v :
  equals n n X M -> is_witness strict n X v = true ->
  0 < square n (column v) /\ form n M (column v) <= 0 /\ (strict = true -> form n M (column v) < 0).
Proof.
  intros HX H. apply both in H. destruct H as [H S]. apply both in H. destruct H as [E N].
  apply are_exact_correct in E. destruct (sign_at_correct n X M _ v HX E) as (_ & Le & Lt).
  destruct (sign_at_correct n _ _ _ v (multiple_of_identity_correct n 1) E) as (Gt & _ & _).
  apply Z.eqb_eq in N. specialize (Gt N). unfold form in Gt. rewrite bilinear_scale in Gt.
  fold (form n identity (column v)) in Gt. rewrite form_identity in Gt.
  replace (Q2R 1) with 1 in Gt by (unfold Q2R; simpl; lra). split; [lra|].
  destruct strict.
  - apply Z.eqb_eq in S. specialize (Lt S). split; [lra|]. intros _. exact Lt.
  - apply Bool.negb_true_iff, Z.eqb_neq in S. split; [exact (Le S)|discriminate].
Qed.

(** M is not positive definite. *)
Theorem not_positive_definite n M v :
  fits n n M &&& is_witness false n (numbers_of n n M) v = true ->
  exists v : vector, 0 < square n v /\ quadratic n M v <= 0.
Proof.
  intros H. apply both in H. destruct H as [Fit H].
  destruct (is_witness_correct _ _ _ _ _ (fits_equals _ _ _ Fit) H) as (N & K & _).
  exists (column v). rewrite quadratic_form by apply (fits_shape _ _ _ Fit). split; assumption.
Qed.

(** M is not positive semidefinite. *)
Theorem not_positive_semidefinite n M v :
  fits n n M &&& is_witness true n (numbers_of n n M) v = true -> exists v : vector, quadratic n M v < 0.
Proof.
  intros H. apply both in H. destruct H as [Fit H].
  destruct (is_witness_correct _ _ _ _ _ (fits_equals _ _ _ Fit) H) as (_ & _ & K).
  exists (column v). rewrite quadratic_form by apply (fits_shape _ _ _ Fit). apply K. reflexivity.
Qed.

(** [S + S'] is not positive semidefinite. *)
Theorem not_accretive n S v :
  fits n n S &&& is_witness true n (numbers_of n n S) v = true -> exists v : vector, 2 * quadratic n S v < 0.
Proof. intros H. destruct (not_positive_semidefinite n S v H) as [w K]. exists w. lra. Qed.

(** [F'P + PF + 2 rate P] is not negative definite. *)
Theorem no_lyapunov_inequality n p A C L P rate v :
  linear_fits n p A C L P
    &&& is_witness false n (negative n n (lyapunov_numbers n (error_numbers n p A C L) (numbers_of n n P) rate))
      v = true ->
  exists v : vector, 0 < square n v /\
    let w := (A * v - L * (C * v))%vector in
    0 <= inner n w (P * v)%vector + inner n v (P * w)%vector + 2 * Q2R rate * quadratic n P v.
Proof.
  intros H. apply both in H. destruct H as [Fit H]. destruct (linear_fits_parts _ _ _ _ _ _ Fit) as (FA & FC & FL & FP).
  destruct (is_witness_correct _ _ _ _ _ (negative_correct _ _ _ _ (lyapunov_numbers_correct _ _ _ rate _ _
    (error_numbers_correct _ _ _ _ _ FA FC FL) (fits_equals _ _ _ FP))) H) as (N & K & _).
  exists (column v). split; [exact N|]. intros w. unfold w. rewrite (lyapunov_quadratic n p) by exact Fit.
  unfold form in K. rewrite bilinear_scale in K. unfold form. lra.
Qed.

(** [F'P F - factor^2 P] is not negative definite. *)
Theorem no_stein_inequality n p A C L P factor v :
  linear_fits n p A C L P
    &&& is_witness false n (negative n n (stein_numbers n (error_numbers n p A C L) (numbers_of n n P) factor))
      v = true ->
  exists v : vector, 0 < square n v /\
    let w := (A * v - L * (C * v))%vector in 0 <= quadratic n P w - Q2R factor ^ 2 * quadratic n P v.
Proof.
  intros H. apply both in H. destruct H as [Fit H]. destruct (linear_fits_parts _ _ _ _ _ _ Fit) as (FA & FC & FL & FP).
  destruct (is_witness_correct _ _ _ _ _ (negative_correct _ _ _ _ (stein_numbers_correct _ _ _ factor _ _
    (error_numbers_correct _ _ _ _ _ FA FC FL) (fits_equals _ _ _ FP))) H) as (N & K & _).
  exists (column v). split; [exact N|]. intros w. unfold w. rewrite (stein_quadratic n p) by exact Fit.
  unfold form in K. rewrite bilinear_scale in K. unfold form. lra.
Qed.
