(** The linear observer in discrete time: the theorem [discrete-observer] of certificates.

    For the plant [x(k+1) = A x(k) + B u(k)], [y = C x] and the observer
    [xhat(k+1) = A xhat(k) + B u(k) + L (y(k) - C xhat(k))] the error [e = x - xhat] obeys [e(k+1) = F e(k)],
    [F = A - L C]. With [V = e'Pe], [lower I <= P <= upper I] and [F'P F <= factor^2 P], V falls at each step at least
    by the factor [factor^2], and [|e(k)| <= overshoot factor^k |e(0)|] if [overshoot^2 lower >= upper]. *)

From Coq Require Import Reals QArith Qreals List Lra Lia.
From Luenberger Require Import Vectors Definite Inequalities.
Import ListNotations.
Local Open Scope R_scope.
Local Open Scope lazy_bool_scope.

(** [x(k+1) = f(k)] for the first n entries. *)
Definition recursion (n : nat) (x f : nat -> vector) : Prop := forall k i, (i < n)%nat -> x (S k) i = f k i.

(** V that falls by [factor^2] at each step. *)
Theorem falls_at_each_step n P (f : R) lower upper overshoot (Between : is_between n P lower upper overshoot = true) :
  0 <= f -> forall e : nat -> vector,
  (forall k, quadratic n P (e (S k)) <= f ^ 2 * quadratic n P (e k)) ->
  (forall k, quadratic n P (e (S k)) <= f ^ 2 * quadratic n P (e k))
  /\ (forall k, quadratic n P (e k) <= f ^ (2 * k) * quadratic n P (e 0%nat))
  /\ (forall k, norm n (e k) <= Q2R overshoot * f ^ k * norm n (e 0%nat)).
Proof.
  intros Sign e Step.
  assert (Steps : forall k, quadratic n P (e k) <= f ^ (2 * k) * quadratic n P (e 0%nat)).
  { induction k as [|k IH]; [simpl; lra|]. apply Rle_trans with (1 := Step k).
    replace (f ^ (2 * S k)) with (f ^ 2 * f ^ (2 * k)) by (rewrite <- pow_add; f_equal; lia).
    rewrite Rmult_assoc. apply Rmult_le_compat_l; [apply pow_le, Sign|exact IH]. }
  split; [exact Step|split; [exact Steps|]]. intros k.
  apply (norm_of_form n P lower upper overshoot Between); [apply pow_le; exact Sign|].
  specialize (Steps k). rewrite !quadratic_form in Steps by apply (is_between_shape _ _ _ _ _ Between).
  replace (f ^ k * f ^ k) with (f ^ (2 * k)); [exact Steps|]. rewrite <- pow_add. f_equal. lia.
Qed.

Definition contracts (n p : nat) (A C L P : list (list Q)) (factor lower upper overshoot : Q) : bool :=
  is_between n P lower upper overshoot &&& Qle_bool 0 factor &&& shrinks n p A C L P factor 0.

Section Error.
  Variables (n p : nat) (A C L P : list (list Q)) (factor lower upper overshoot : Q).
  Hypothesis Checked : contracts n p A C L P factor lower upper overshoot = true.

  Lemma parts : is_between n P lower upper overshoot = true /\ 0 <= Q2R factor /\ shrinks n p A C L P factor 0 = true.
  Proof.
    pose proof (both _ _ Checked) as [H Shrinks]. pose proof (both _ _ H) as [Between Sign]. repeat split;
      try assumption.
    apply Qle_bool_iff, Qle_Rle in Sign. rewrite Q2R_zero in Sign. exact Sign.
  Qed.

  Lemma shapes : has_shape n n A = true /\ has_shape p n C = true /\ has_shape n p L = true /\ has_shape n n P = true.
  Proof.
    destruct parts as (_ & _ & H). pose proof (both _ _ H) as [Fit _].
    destruct (linear_fits_parts _ _ _ _ _ _ Fit) as (FA & FC & FL & FP).
    repeat split; eapply fits_shape; eassumption.
  Qed.

  (** Every solution of [e(k+1) = (A - L C)e(k)] has [V(k) <= factor^(2k) V(0)], more exactly [V(k+1) <= factor^2 V(k)],
      and [|e(k)| <= overshoot factor^k |e(0)|]. *)
  Theorem error_contracts (e : nat -> vector) :
    recursion n e (fun k => A * e k - L * (C * e k))%vector ->
    (forall k, quadratic n P (e (S k)) <= Q2R factor ^ 2 * quadratic n P (e k))
    /\ (forall k, quadratic n P (e k) <= Q2R factor ^ (2 * k) * quadratic n P (e 0%nat))
    /\ (forall k, norm n (e k) <= Q2R overshoot * Q2R factor ^ k * norm n (e 0%nat)).
  Proof.
    intros E. destruct parts as (Between & Sign & Shrinks). destruct shapes as (HA & HC & HL & HP).
    apply (falls_at_each_step n P (Q2R factor) lower upper overshoot Between Sign). intros k.
    rewrite !quadratic_form by exact HP.
    pose proof (shrinks_form _ _ _ _ _ _ _ _ Shrinks (e k)) as K. rewrite Q2R_zero in K.
    rewrite (form_ext n (real P) (real P) (e (S k)) (apply n (error_matrix p A C L) (e k))); [lra|easy|].
    intros i I. rewrite (E k i I). apply (error_apply n p); assumption.
  Qed.

  (** The same of the error of plant and observer, for every input. *)
  Theorem observer_contracts (B : list (list Q)) (u x xhat : nat -> vector) :
    recursion n x (fun k => A * x k + B * u k)%vector ->
    recursion n xhat (fun k => A * xhat k + B * u k + L * (C * x k - C * xhat k))%vector ->
    let e k := (x k - xhat k)%vector in
    (forall k, quadratic n P (e (S k)) <= Q2R factor ^ 2 * quadratic n P (e k))
    /\ (forall k, quadratic n P (e k) <= Q2R factor ^ (2 * k) * quadratic n P (e 0%nat))
    /\ (forall k, norm n (e k) <= Q2R overshoot * Q2R factor ^ k * norm n (e 0%nat)).
  Proof.
    intros Plant Observer e. apply error_contracts. destruct shapes as (HA & HC & HL & _).
    intros k i I. unfold e at 1, minus_vector at 1. rewrite (Plant k i I), (Observer k i I).
    apply (difference_of_right_sides n p); assumption.
  Qed.
End Error.
