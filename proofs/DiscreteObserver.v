(** The linear observer in discrete time: the theorem [discrete-observer] of certificates.

    For the plant [x(k+1) = A x(k) + B u(k)], [y = C x] and the observer
    [xhat(k+1) = A xhat(k) + B u(k) + L (y(k) - C xhat(k))] the error [e = x - xhat] obeys [e(k+1) = F e(k)],
    [F = A - L C]. With [V = e'Pe], [lower I <= P <= upper I] and [F'P F <= factor^2 P], V falls at each step at least by
    the factor [factor^2], and [|e(k)| <= overshoot factor^k |e(0)|] if [overshoot^2 lower >= upper]. *)

From Coq Require Import Reals QArith Qreals List Lra Lia.
From Luenberger Require Import Vectors Definite Inequalities.
Import ListNotations.
Local Open Scope R_scope.
Local Open Scope lazy_bool_scope.

(** [x(k+1) = f(k)] for the first n entries. *)
Definition recursion (n : nat) (x f : nat -> vector) : Prop := forall k i, (i < n)%nat -> x (S k) i = f k i.

Definition contracts (n p : nat) (A C L P : list (list Q)) (factor lower upper overshoot : Q) : bool :=
  is_between n P lower upper overshoot &&& Qle_bool 0 factor &&& shrinks n p A C L P factor 0.

Section Observer.
  Variables (n p : nat) (A B C L P : list (list Q)) (factor lower upper overshoot : Q).
  Hypothesis Checked : contracts n p A C L P factor lower upper overshoot = true.
  Variables u x xhat : nat -> vector.
  Hypothesis Plant : recursion n x (fun k => A * x k + B * u k)%vector.
  Hypothesis Observer : recursion n xhat (fun k => A * xhat k + B * u k + L * (C * x k - C * xhat k))%vector.

  Let e k : vector := (x k - xhat k)%vector.
  Let F := error_matrix p A C L.

  Lemma parts : is_between n P lower upper overshoot = true /\ 0 <= Q2R factor /\ shrinks n p A C L P factor 0 = true.
  Proof.
    pose proof (both _ _ Checked) as [H Shrinks]. pose proof (both _ _ H) as [Between Sign]. repeat split; try assumption.
    apply Qle_bool_iff, Qle_Rle in Sign. rewrite Q2R_zero in Sign. exact Sign.
  Qed.

  Lemma error_recursion k i : (i < n)%nat -> e (S k) i = apply n F (e k) i.
  Proof.
    intros I. destruct parts as (_ & _ & H). apply both in H. destruct H as [Fit _].
    destruct (linear_fits_parts _ _ _ _ _ _ Fit) as (FA & FC & FL & _).
    assert (HA := fits_shape _ _ _ FA). assert (HC := fits_shape _ _ _ FC). assert (HL := fits_shape _ _ _ FL).
    unfold e at 1, minus_vector at 1. rewrite (Plant k i I), (Observer k i I). unfold F, error_matrix.
    rewrite apply_minus, apply_product. unfold e, minus_vector, plus_vector. rewrite apply_minus_vector.
    rewrite (times_vector_apply n n A (x k)), (times_vector_apply n n A (xhat k)) by assumption.
    rewrite (times_vector_apply n p L) by assumption.
    rewrite (apply_ext p (real L) (real L) (fun j => (C * x k)%vector j - (C * xhat k)%vector j)
               (apply n (real C) (fun j => x k j - xhat k j)) i); try reflexivity.
    - ring.
    - intros j J. rewrite apply_minus_vector, !(times_vector_apply p n) by assumption. reflexivity.
  Qed.

  Lemma step k : form n (real P) (e (S k)) <= Q2R factor * Q2R factor * form n (real P) (e k).
  Proof.
    destruct parts as (_ & _ & H). pose proof (shrinks_form _ _ _ _ _ _ _ _ H (e k)) as K. rewrite Q2R_zero in K.
    rewrite (form_ext n (real P) (real P) (e (S k)) (apply n F (e k))); [unfold F; lra|easy|].
    intros i I. apply error_recursion, I.
  Qed.

  Lemma steps k : form n (real P) (e k) <= Q2R factor ^ k * Q2R factor ^ k * form n (real P) (e 0%nat).
  Proof.
    induction k as [|k IH]; [simpl; lra|]. apply Rle_trans with (1 := step k).
    simpl pow. set (f := Q2R factor) in *.
    replace (f * f ^ k * (f * f ^ k) * form n (real P) (e 0%nat)) with (f * f * (f ^ k * f ^ k * form n (real P) (e 0%nat))) by ring.
    apply Rmult_le_compat_l; [apply Rle_0_sqr|exact IH].
  Qed.

  (** [V(k+1) <= factor^2 V(k)] *)
  Theorem observer_step k : quadratic n P (e (S k)) <= Q2R factor ^ 2 * quadratic n P (e k).
  Proof.
    destruct parts as (Between & _ & _). rewrite !quadratic_form by apply (is_between_shape _ _ _ _ _ Between).
    replace (Q2R factor ^ 2) with (Q2R factor * Q2R factor) by ring. apply step.
  Qed.

  (** [V(k) <= factor^(2k) V(0)] *)
  Theorem observer_steps k : quadratic n P (e k) <= Q2R factor ^ (2 * k) * quadratic n P (e 0%nat).
  Proof.
    destruct parts as (Between & _ & _). rewrite !quadratic_form by apply (is_between_shape _ _ _ _ _ Between).
    replace (Q2R factor ^ (2 * k)) with (Q2R factor ^ k * Q2R factor ^ k); [apply steps|].
    rewrite <- pow_add. f_equal. lia.
  Qed.

  (** [|e(k)| <= overshoot factor^k |e(0)|] *)
  Theorem observer_norm k : norm n (e k) <= Q2R overshoot * Q2R factor ^ k * norm n (e 0%nat).
  Proof.
    destruct parts as (Between & Sign & _).
    apply (norm_of_form n P lower upper overshoot Between); [apply pow_le; exact Sign|apply steps].
  Qed.
End Observer.
