(** The linear observer in continuous time: the theorem [linear-observer] of certificates.

    For the plant [x' = A x + B u], [y = C x] and the observer [xhat' = A xhat + B u + L (y - C xhat)] the error
    [e = x - xhat] obeys [e' = F e], [F = A - L C]. With [V = e'Pe], [lower I <= P <= upper I] and
    [F'P + PF + 2 a P <= 0], [V(t) <= exp(-2 a (t - s)) V(s)] for [0 <= s <= t], and
    [|e(t)| <= overshoot exp(-a t) |e(0)|] if [overshoot^2 lower >= upper]. *)

From Coq Require Import Reals QArith Qreals List Lra Lia.
From Luenberger Require Import Vectors Definite Inequalities Decay.
Import ListNotations.
Local Open Scope R_scope.
Local Open Scope lazy_bool_scope.

(** ** The theorem, for matrices of real numbers *)

Section Decay.
  Variables (n : nat) (P : matrix) (a : R).
  Variables (T : R) (e f : R -> vector).
  Hypothesis E : solution T n e f.
  Hypothesis Falls : forall t, 0 < t < T ->
    bilinear n n P (f t) (e t) + bilinear n n P (e t) (f t) + 2 * a * form n P (e t) <= 0.

  Lemma lyapunov_decay s t : 0 <= s -> s <= t -> t < T -> form n P (e t) <= exp (- (2 * a) * (t - s)) * form n P (e s).
  Proof.
    intros Hs L Ht.
    assert (K : exp (2 * a * t) * form n P (e t) <= exp (2 * a * s) * form n P (e s)).
    { apply (decreasing T (fun t => exp (2 * a * t) * form n P (e t))
        (fun t => 2 * a * exp (2 * a * t) * form n P (e t)
                  + exp (2 * a * t) * (bilinear n n P (f t) (e t) + bilinear n n P (e t) (f t)))); try assumption.
      - apply right_continuous_mult; [apply (right_continuous_derivable _ _ (derivative_exponential (2 * a) 0))|].
        apply right_continuous_form. intros i I. apply (E i I).
      - intros r Hr. apply (derivable_pt_lim_mult (fun t => exp (2 * a * t)) (fun t => form n P (e t))).
        + apply derivative_exponential.
        + apply derivative_form. intros i I. apply (E i I). exact Hr.
      - intros r Hr. specialize (Falls r Hr). pose proof (exp_pos (2 * a * r)). nra. }
    assert (X : exp (- (2 * a) * (t - s)) = exp (- (2 * a) * t) * exp (2 * a * s)) by (rewrite <- exp_plus; f_equal;
      ring).
    assert (Y : exp (- (2 * a) * t) * exp (2 * a * t) = 1) by (rewrite <- exp_plus, <- exp_0; f_equal; ring).
    rewrite X, Rmult_assoc. replace (form n P (e t)) with (exp (- (2 * a) * t) * (exp (2 * a * t) * form n P (e t))).
    - apply Rmult_le_compat_l; [apply Rlt_le, exp_pos|exact K].
    - rewrite <- Rmult_assoc, Y. ring.
  Qed.
End Decay.

(** Of solutions of plant and observer the difference is one of [e' = F e]. *)
Lemma solution_difference T n (x xhat f g : R -> vector) :
  solution T n x f -> solution T n xhat g -> solution T n (fun t => x t - xhat t)%vector (fun t => f t - g t)%vector.
Proof.
  intros X Y i I. destruct (X i I) as [Cx Dx]. destruct (Y i I) as [Cy Dy]. split.
  - apply right_continuous_minus; assumption.
  - intros t Ht. apply (derivable_pt_lim_minus (fun s => x s i) (fun s => xhat s i)); [apply Dx|apply Dy]; exact Ht.
Qed.

Lemma solution_ext T n x f g :
  (forall t i, (i < n)%nat -> f t i = g t i) -> solution T n x f -> solution T n x g.
Proof.
  intros H X i I. destruct (X i I) as [C D]. split; [exact C|]. intros t Ht. rewrite <- H by exact I. apply D, Ht.
Qed.

(** ** The statement about trajectories *)

(** [lower I <= P <= upper I], [F'P + PF + 2 a P <= 0] and [upper <= overshoot^2 lower]. *)
Definition decays (n p : nat) (A C L P : list (list Q)) (a lower upper overshoot : Q) : bool :=
  is_between n P lower upper overshoot &&& falls n p A C L P a 0.

Section Error.
  Variables (n p : nat) (A C L P : list (list Q)) (a lower upper overshoot : Q).
  Hypothesis Checked : decays n p A C L P a lower upper overshoot = true.

  Let F := error_matrix p A C L.

  Lemma shapes : has_shape n n A = true /\ has_shape p n C = true /\ has_shape n p L = true /\ has_shape n n P = true.
  Proof.
    pose proof (both _ _ Checked) as [_ H]. pose proof (both _ _ H) as [Fit _].
    destruct (linear_fits_parts _ _ _ _ _ _ Fit) as (FA & FC & FL & FP).
    repeat split; eapply fits_shape; eassumption.
  Qed.

  Lemma error_falls v : bilinear n n (real P) (apply n F v) v + bilinear n n (real P) v (apply n F v)
    + 2 * Q2R a * form n (real P) v <= 0.
  Proof.
    pose proof (both _ _ Checked) as [_ H]. pose proof (falls_form _ _ _ _ _ _ _ _ H v) as K.
    rewrite Q2R_zero, lyapunov_form in K. unfold F. lra.
  Qed.

  (** Every solution of [e' = (A - L C)e] has [V(t) <= exp(-2 a (t - s)) V(s)] for [0 <= s <= t], and
      [|e(t)| <= overshoot exp(-a t) |e(0)|]. *)
  Theorem error_decays (T : R) (e : R -> vector) :
    solution T n e (fun t => A * e t - L * (C * e t))%vector ->
    (forall s t, 0 <= s -> s <= t -> t < T ->
      quadratic n P (e t) <= exp (- (2 * Q2R a) * (t - s)) * quadratic n P (e s))
    /\ (forall t, 0 <= t -> t < T -> norm n (e t) <= Q2R overshoot * exp (- Q2R a * t) * norm n (e 0)).
  Proof.
    intros E. destruct shapes as (HA & HC & HL & HP).
    assert (S : solution T n e (fun t => apply n F (e t))).
    { apply (solution_ext T n e (fun t => A * e t - L * (C * e t))%vector); [|exact E].
      intros t i I. apply (error_apply n p); assumption. }
    assert (K : forall s t, 0 <= s -> s <= t -> t < T ->
      quadratic n P (e t) <= exp (- (2 * Q2R a) * (t - s)) * quadratic n P (e s)).
    { intros s t Hs Hst Ht. rewrite !quadratic_form by exact HP.
      apply (lyapunov_decay n (real P) (Q2R a) T e (fun t => apply n F (e t)) S); try assumption.
      intros r _. apply error_falls. }
    split; [exact K|]. intros t Hs Ht. pose proof (both _ _ Checked) as [Between _].
    apply (norm_of_form n P lower upper overshoot Between); [apply Rlt_le, exp_pos|].
    specialize (K 0 t (Rle_refl 0) Hs Ht). rewrite !quadratic_form, Rminus_0_r in K by exact HP.
    replace (exp (- Q2R a * t) * exp (- Q2R a * t)) with (exp (- (2 * Q2R a) * t)); [exact K|].
    rewrite <- exp_plus. f_equal. ring.
  Qed.

  (** The same of the error of plant and observer, for every input. *)
  Theorem observer_decays (B : list (list Q)) (T : R) (u x xhat : R -> vector) :
    solution T n x (fun t => A * x t + B * u t)%vector ->
    solution T n xhat (fun t => A * xhat t + B * u t + L * (C * x t - C * xhat t))%vector ->
    let e t := (x t - xhat t)%vector in
    (forall s t, 0 <= s -> s <= t -> t < T ->
      quadratic n P (e t) <= exp (- (2 * Q2R a) * (t - s)) * quadratic n P (e s))
    /\ (forall t, 0 <= t -> t < T -> norm n (e t) <= Q2R overshoot * exp (- Q2R a * t) * norm n (e 0)).
  Proof.
    intros Plant Observer e. apply error_decays. destruct shapes as (HA & HC & HL & _).
    apply (solution_ext T n e (fun t i => (A * x t + B * u t)%vector i -
      (A * xhat t + B * u t + L * (C * x t - C * xhat t))%vector i)).
    - intros t i I. rewrite (difference_of_right_sides n p) by assumption. reflexivity.
    - apply solution_difference; assumption.
  Qed.
End Error.
