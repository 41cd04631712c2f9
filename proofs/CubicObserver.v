(** The cubic observer in continuous time: the theorems [cubic-observer], from every initial error, and
    [cubic-observer-with-structured-gain] of certificates.

    The error of [xhat' = A xhat + B u + L r - (r'theta r) N r], [r = y - C xhat], obeys
    [e' = F e + (y'theta y) N y], [y = C e], [F = A - L C]. If [P N = -C'S] with [S + S' >= 0] and [theta >= 0], the
    cubic term adds [-2 (y'theta y) y'S y <= 0] to the derivative of [V = e'Pe], which falls as without it. The
    statements are about every solution on every interval [0 <= t < T] on which it exists; that it exists for all times
    follows on paper from the bound, and is not proved here. *)

From Coq Require Import Reals QArith Qreals ZArith List Lra Lia.
From Luenberger Require Import Vectors Definite Inequalities Decay LinearObserver.
Import ListNotations.
Local Open Scope R_scope.
Local Open Scope lazy_bool_scope.

(** [P N = -C'S] *)
Definition has_structure (n p : nat) (C P S : list (list Q)) (N : matrix) : Prop :=
  same n p (product n (real P) N) (scale (-1) (product p (transpose (real C)) (real S))).

Definition is_symmetric (n : nat) (X : numbers) : bool :=
  all n (fun i => all n (fun j => get (fst X) i j =? get (fst X) j i)%Z).

Lemma is_symmetric_correct n X M x y :
  equals n n X M -> is_symmetric n X = true -> bilinear n n M x y = bilinear n n M y x.
Proof.
  intros E H. rewrite <- (bilinear_transpose n n M y x). apply bilinear_ext; try reflexivity.
  intros i j I J. unfold transpose. rewrite <- (E i j I J), <- (E j i J I). unfold value.
  apply (all_correct _ _ i) in H; [|exact I]. apply (all_correct _ _ j) in H; [|exact J].
  apply Z.eqb_eq in H. rewrite H. reflexivity.
Qed.

(** What the linear observer needs, [theta >= 0] and [S + S' >= 0]. *)
Definition cubic_decays (n p : nat) (A C L P theta S : list (list Q)) (a lower upper overshoot : Q) : bool :=
  decays n p A C L P a lower upper overshoot
    &&& is_symmetric n (numbers_of n n P)
    &&& fits p p theta &&& semidefinite p (numbers_of p p theta)
    &&& fits p p S &&& semidefinite p (added p p (numbers_of p p S) (turned p p (numbers_of p p S))).

(** [A e - L y + (y'theta y) N y], [y = C e] *)
Definition cubic_error (p : nat) (A C L theta : list (list Q)) (N : matrix) (e : vector) : vector :=
  let y := (C * e)%vector in (A * e - L * y + quadratic p theta y .* apply p N y)%vector.

Section Error.
  Variables (n p : nat) (A C L P theta S : list (list Q)) (a lower upper overshoot : Q).
  Hypothesis Checked : cubic_decays n p A C L P theta S a lower upper overshoot = true.
  Variable N : matrix.
  Hypothesis Structure : has_structure n p C P S N.

  Lemma cubic_parts :
    decays n p A C L P a lower upper overshoot = true
    /\ (forall x y, bilinear n n (real P) x y = bilinear n n (real P) y x)
    /\ (forall y, 0 <= form p (real theta) y) /\ (forall y, 0 <= form p (real S) y) /\ has_shape p p theta = true.
  Proof.
    pose proof Checked as H. apply both in H. destruct H as [H Accretive]. apply both in H. destruct H as [H FS].
    apply both in H. destruct H as [H Theta]. apply both in H. destruct H as [H FT].
    apply both in H. destruct H as [Decays Symmetric].
    pose proof (both _ _ Decays) as [_ Falls]. pose proof (both _ _ Falls) as [Fit _].
    destruct (linear_fits_parts _ _ _ _ _ _ Fit) as (_ & _ & _ & FP). repeat split.
    - exact Decays.
    - intros x y. apply (is_symmetric_correct n _ _ _ _ (fits_equals _ _ _ FP) Symmetric).
    - apply (semidefinite_correct _ _ _ (fits_equals _ _ _ FT) Theta).
    - intros y.
      pose proof (semidefinite_correct _ _ _ (added_correct _ _ _ _ _ _ (fits_equals _ _ _ FS)
        (turned_correct _ _ _ _ (fits_equals _ _ _ FS))) Accretive y) as K.
      unfold form in K. rewrite bilinear_plus, bilinear_transpose in K. unfold form. lra.
    - apply fits_shape, FT.
  Qed.

  (** [e'P N y = -y'S y] *)
  Lemma cubic_term e : bilinear n n (real P) e (apply p N (apply n (real C) e))
    = - form p (real S) (apply n (real C) e).
  Proof.
    rewrite <- bilinear_product.
    rewrite (bilinear_ext n p _ (scale (-1) (product p (transpose (real C)) (real S))) e (apply n (real C) e)
      e (apply n (real C) e) Structure)
      by reflexivity.
    rewrite bilinear_scale, bilinear_transpose_product. unfold form. ring.
  Qed.

  Theorem cubic_error_decays (T : R) (e : R -> vector) :
    solution T n e (fun t => cubic_error p A C L theta N (e t)) ->
    (forall s t, 0 <= s -> s <= t -> t < T ->
      quadratic n P (e t) <= exp (- (2 * Q2R a) * (t - s)) * quadratic n P (e s))
    /\ (forall t, 0 <= t -> t < T -> norm n (e t) <= Q2R overshoot * exp (- Q2R a * t) * norm n (e 0)).
  Proof.
    intros E. destruct cubic_parts as (Decays & Symmetric & Theta & Accretive & ShapeTheta).
    destruct (shapes _ _ _ _ _ _ _ _ _ _ Decays) as (HA & HC & HL & HP).
    set (F := error_matrix p A C L).
    set (c := fun v => form p (real theta) (apply n (real C) v)).
    set (f := fun v : vector => (fun i => apply n F v i + c v * apply p N (apply n (real C) v) i) : vector).
    assert (S' : solution T n e (fun t => f (e t))).
    { apply (solution_ext T n e (fun t => cubic_error p A C L theta N (e t))); [|exact E].
      intros t i I. unfold cubic_error, plus_vector at 1, scale_vector, f. f_equal.
      - apply (error_apply n p); assumption.
      - assert (Y : forall j, (j < p)%nat -> (C * e t)%vector j = apply n (real C) (e t) j).
        { intros j J. apply (times_vector_apply p); assumption. }
        f_equal.
        + rewrite quadratic_form by assumption. apply form_ext; [easy|exact Y].
        + apply apply_ext; [reflexivity|exact Y]. }
    assert (Falls : forall v, bilinear n n (real P) (f v) v + bilinear n n (real P) v (f v)
      + 2 * Q2R a * form n (real P) v <= 0).
    { intros v. pose proof (error_falls _ _ _ _ _ _ _ _ _ _ Decays v) as K. fold F in K. unfold f.
      rewrite (bilinear_plus_left n n), bilinear_scale_left.
      rewrite (bilinear_plus_right n n), bilinear_scale_right.
      rewrite (Symmetric (apply p N (apply n (real C) v)) v), cubic_term.
      assert (0 <= c v * form p (real S) (apply n (real C) v)) by (apply Rmult_le_pos; [apply Theta|apply Accretive]).
      lra. }
    assert (K : forall s t, 0 <= s -> s <= t -> t < T ->
      quadratic n P (e t) <= exp (- (2 * Q2R a) * (t - s)) * quadratic n P (e s)).
    { intros s t Hs Hst Ht. rewrite !quadratic_form by exact HP.
      apply (lyapunov_decay n (real P) (Q2R a) T e (fun t => f (e t)) S'); try assumption.
      intros r _. apply Falls. }
    split; [exact K|]. intros t Hs Ht. pose proof (both _ _ Decays) as [Between _].
    apply (norm_of_form n P lower upper overshoot Between); [apply Rlt_le, exp_pos|].
    specialize (K 0 t (Rle_refl 0) Hs Ht). rewrite !quadratic_form, Rminus_0_r in K by exact HP.
    replace (exp (- Q2R a * t) * exp (- Q2R a * t)) with (exp (- (2 * Q2R a) * t)); [exact K|].
    rewrite <- exp_plus. f_equal. ring.
  Qed.

  (** The same of the error of plant and observer, for every input. *)
  Theorem cubic_observer_decays (B : list (list Q)) (T : R) (u x xhat : R -> vector) :
    solution T n x (fun t => A * x t + B * u t)%vector ->
    solution T n xhat (fun t => let r := (C * x t - C * xhat t)%vector in
      (A * xhat t + B * u t + L * r - quadratic p theta r .* apply p N r)%vector) ->
    let e t := (x t - xhat t)%vector in
    (forall s t, 0 <= s -> s <= t -> t < T ->
      quadratic n P (e t) <= exp (- (2 * Q2R a) * (t - s)) * quadratic n P (e s))
    /\ (forall t, 0 <= t -> t < T -> norm n (e t) <= Q2R overshoot * exp (- Q2R a * t) * norm n (e 0)).
  Proof.
    intros Plant Observer e. apply cubic_error_decays.
    destruct cubic_parts as (Decays & _ & _ & _ & ShapeTheta).
    destruct (shapes _ _ _ _ _ _ _ _ _ _ Decays) as (HA & HC & HL & _).
    refine (solution_ext T n e (fun t i => (A * x t + B * u t)%vector i - _ t i) _ _
      (solution_difference T n x xhat _ _ Plant Observer)).
    intros t i I. cbv beta zeta. set (r := (C * x t - C * xhat t)%vector).
    assert (Y : forall j, (j < p)%nat -> r j = (C * e t)%vector j).
    { intros j J. unfold r, e, minus_vector. rewrite !(times_vector_apply p n C) by assumption.
      symmetry. apply apply_minus_vector. }
    pose proof (difference_of_right_sides n p A B C L (u t) (x t) (xhat t) i HA HC HL I) as D. fold r in D.
    change (minus_vector (x t) (xhat t)) with (e t) in D.
    assert (Q : quadratic p theta (C * e t)%vector = quadratic p theta r).
    { rewrite !quadratic_form by exact ShapeTheta. apply form_ext; [easy|]. intros j J. symmetry. apply Y, J. }
    assert (W : apply p N (C * e t)%vector i = apply p N r i).
    { apply apply_ext; [reflexivity|]. intros j J. symmetry. apply Y, J. }
    unfold cubic_error. unfold plus_vector, minus_vector, scale_vector in *. rewrite Q, W. lra.
  Qed.
End Error.

(** Whether stored numbers N have the structure exactly. *)
Definition is_structured (n p : nat) (C P S N : list (list Q)) : bool :=
  fits p n C &&& fits n n P &&& fits p p S &&& fits n p N
    &&& (let zero := added n p (times n n p (numbers_of n n P) (numbers_of n p N))
                       (times n p p (turned n p (numbers_of p n C)) (numbers_of p p S)) in
         all n (fun i => all p (fun j => get (fst zero) i j =? 0)%Z)).

Theorem is_structured_correct n p C P S N : is_structured n p C P S N = true -> has_structure n p C P S (real N).
Proof.
  intros H. apply both in H. destruct H as [H Zero]. apply both in H. destruct H as [H FN].
  apply both in H. destruct H as [H FS]. apply both in H. destruct H as [FC FP].
  intros i j I J. cbv zeta in Zero.
  apply (all_correct _ _ i) in Zero; [|exact I]. apply (all_correct _ _ j) in Zero; [|exact J]. apply Z.eqb_eq in Zero.
  pose proof (added_correct n p _ _ _ _ (times_correct n n p _ _ _ _ (fits_equals _ _ _ FP) (fits_equals _ _ _ FN))
    (times_correct n p p _ _ _ _ (turned_correct n p _ _ (fits_equals _ _ _ FC)) (fits_equals _ _ _ FS)) i j I J) as K.
  unfold value in K. rewrite Zero in K. unfold plus in K. unfold scale. unfold Rdiv in K. rewrite Rmult_0_l in K. lra.
Qed.

(** The fact [S + S' >= 0] of certificates, with its margin q. *)
Theorem accretive p S q :
  fits p p S &&& at_least p (added p p (numbers_of p p S) (turned p p (numbers_of p p S))) q = true ->
  forall v, Q2R q * square p v <= 2 * quadratic p S v.
Proof.
  intros H v. apply both in H. destruct H as [FS H]. rewrite quadratic_form by apply (fits_shape _ _ _ FS).
  pose proof (at_least_correct _ _ _ _ (added_correct _ _ _ _ _ _ (fits_equals _ _ _ FS)
    (turned_correct _ _ _ _ (fits_equals _ _ _ FS))) H v) as K.
  unfold form in K. rewrite bilinear_plus, bilinear_transpose in K. unfold form. lra.
Qed.
