(** The cubic observer in continuous time: the theorems [cubic-observer], from every initial error,
    [cubic-observer-with-structured-gain] and [cubic-observer-theorem-1] of certificates.

    The error of [xhat' = A xhat + B u + L r - (r'theta r) N r], [r = y - C xhat], obeys
    [e' = F e + (y'theta y) N y], [y = C e], [F = A - L C]. If [P N = -C'S] with [S + S' >= 0] and [theta >= 0], the
    cubic term adds [-2 (y'theta y) y'S y <= 0] to the derivative of [V = e'Pe], which falls as without it. The
    statements are about every solution on every interval [0 <= t < T] on which it exists; that from every e(0) there is
    one for all times is proved in CubicExistence.v. *)

From Coq Require Import Reals QArith Qreals ZArith List Lra Lia.
From Luenberger Require Import Vectors Definite Inequalities Decay LinearObserver Nullspace Refuted.
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

(** What the linear observer needs, [P = P'] and [theta >= 0]. *)
Definition cubic_decays (n p : nat) (A C L P theta : list (list Q)) (a lower upper overshoot : Q) : bool :=
  decays n p A C L P a lower upper overshoot
    &&& is_symmetric n (numbers_of n n P)
    &&& fits p p theta &&& semidefinite p (numbers_of p p theta).

(** The cubic term does not increase V: [e'P N C e <= 0] for every e, which is (13'). *)
Definition dissipates (n p : nat) (C P : list (list Q)) (N : matrix) : Prop :=
  forall e, bilinear n n (real P) e (apply p N (apply n (real C) e)) <= 0.

(** [S + S' >= 0] *)
Definition is_accretive (p : nat) (S : list (list Q)) : bool :=
  fits p p S &&& semidefinite p (added p p (numbers_of p p S) (turned p p (numbers_of p p S))).

(** [C'(S + S')C >= q C'C]: the same for the values that outputs take. *)
Definition is_accretive_on_outputs (n p : nat) (C S : list (list Q)) (q : Q) : bool :=
  fits p n C &&& fits p p S
    &&& (let both := subtracted p p (added p p (numbers_of p p S) (turned p p (numbers_of p p S)))
                       (multiple_of_identity p q) in
         semidefinite n (times n p n (turned n p (numbers_of p n C)) (times p p n both (numbers_of p n C)))).

(** [A e - L y + (y'theta y) N y], [y = C e] *)
Definition cubic_error (p : nat) (A C L theta : list (list Q)) (N : matrix) (e : vector) : vector :=
  let y := (C * e)%vector in (A * e - L * y + quadratic p theta y .* apply p N y)%vector.

(** The same with sums over n and p terms. *)
Definition cubic_flow (n p : nat) (A C L theta : list (list Q)) (N : matrix) (v : vector) : vector := fun i =>
  apply n (error_matrix p A C L) v i
    + form p (real theta) (apply n (real C) v) * apply p N (apply n (real C) v) i.

Lemma cubic_error_flow n p A C L theta N e i :
  has_shape n n A = true -> has_shape p n C = true -> has_shape n p L = true -> has_shape p p theta = true ->
  (i < n)%nat -> cubic_error p A C L theta N e i = cubic_flow n p A C L theta N e i.
Proof.
  intros HA HC HL Ht I. unfold cubic_error, plus_vector at 1, scale_vector, cubic_flow. f_equal.
  - apply (error_apply n p); assumption.
  - assert (Y : forall j, (j < p)%nat -> (C * e)%vector j = apply n (real C) e j).
    { intros j J. apply (times_vector_apply p); assumption. }
    f_equal.
    + rewrite quadratic_form by assumption. apply form_ext; [easy|exact Y].
    + apply apply_ext; [reflexivity|exact Y].
Qed.

Section Error.
  Variables (n p : nat) (A C L P theta : list (list Q)) (a lower upper overshoot : Q).
  Hypothesis Checked : cubic_decays n p A C L P theta a lower upper overshoot = true.
  Variable N : matrix.
  Hypothesis Dissipates : dissipates n p C P N.

  Lemma cubic_parts :
    decays n p A C L P a lower upper overshoot = true
    /\ (forall x y, bilinear n n (real P) x y = bilinear n n (real P) y x)
    /\ (forall y, 0 <= form p (real theta) y) /\ has_shape p p theta = true.
  Proof.
    pose proof Checked as H. apply both in H. destruct H as [H Theta]. apply both in H. destruct H as [H FT].
    apply both in H. destruct H as [Decays Symmetric].
    pose proof (both _ _ Decays) as [_ Falls]. pose proof (both _ _ Falls) as [Fit _].
    destruct (linear_fits_parts _ _ _ _ _ _ Fit) as (_ & _ & _ & FP). repeat split.
    - exact Decays.
    - intros x y. apply (is_symmetric_correct n _ _ _ _ (fits_equals _ _ _ FP) Symmetric).
    - apply (semidefinite_correct _ _ _ (fits_equals _ _ _ FT) Theta).
    - apply fits_shape, FT.
  Qed.

  Lemma cubic_flow_falls v :
    let f := cubic_flow n p A C L theta N v in
    bilinear n n (real P) f v + bilinear n n (real P) v f + 2 * Q2R a * form n (real P) v <= 0.
  Proof.
    destruct cubic_parts as (Decays & Symmetric & Theta & _).
    pose proof (error_falls _ _ _ _ _ _ _ _ _ _ Decays v) as K. set (F := error_matrix p A C L) in *.
    set (c := form p (real theta) (apply n (real C) v)). set (d := apply p N (apply n (real C) v)).
    cbv zeta. change (cubic_flow n p A C L theta N v) with (fun i => apply n F v i + c * d i).
    rewrite (bilinear_plus_left n n), bilinear_scale_left.
    rewrite (bilinear_plus_right n n), bilinear_scale_right.
    rewrite (Symmetric d v). specialize (Dissipates v). fold d in Dissipates.
    assert (0 <= c * - bilinear n n (real P) v d) by (apply Rmult_le_pos; [apply Theta|lra]).
    lra.
  Qed.

  Theorem cubic_error_decays (T : R) (e : R -> vector) :
    solution T n e (fun t => cubic_error p A C L theta N (e t)) ->
    (forall s t, 0 <= s -> s <= t -> t < T ->
      quadratic n P (e t) <= exp (- (2 * Q2R a) * (t - s)) * quadratic n P (e s))
    /\ (forall t, 0 <= t -> t < T -> norm n (e t) <= Q2R overshoot * exp (- Q2R a * t) * norm n (e 0)).
  Proof.
    intros E. destruct cubic_parts as (Decays & _ & _ & ShapeTheta).
    destruct (shapes _ _ _ _ _ _ _ _ _ _ Decays) as (HA & HC & HL & HP).
    assert (S' : solution T n e (fun t => cubic_flow n p A C L theta N (e t))).
    { apply (solution_ext T n e (fun t => cubic_error p A C L theta N (e t))); [|exact E].
      intros t i I. apply cubic_error_flow; assumption. }
    assert (K : forall s t, 0 <= s -> s <= t -> t < T ->
      quadratic n P (e t) <= exp (- (2 * Q2R a) * (t - s)) * quadratic n P (e s)).
    { intros s t Hs Hst Ht. rewrite !quadratic_form by exact HP.
      apply (lyapunov_decay n (real P) (Q2R a) T e _ S'); try assumption.
      intros r _. apply cubic_flow_falls. }
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
    destruct cubic_parts as (Decays & _ & _ & ShapeTheta).
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

(** ** Gains that dissipate *)

(** [e'P N C e = -y'S y], [y = C e], where [P N = -C'S]. *)
Lemma structured_term n p C P S N e : has_structure n p C P S N ->
  bilinear n n (real P) e (apply p N (apply n (real C) e)) = - form p (real S) (apply n (real C) e).
Proof.
  intros Structure. rewrite <- bilinear_product.
  rewrite (bilinear_ext n p _ (scale (-1) (product p (transpose (real C)) (real S))) e (apply n (real C) e)
    e (apply n (real C) e) Structure)
    by reflexivity.
  rewrite bilinear_scale, bilinear_transpose_product. unfold form. ring.
Qed.

Theorem structure_dissipates n p C P S N :
  is_accretive p S = true -> has_structure n p C P S N -> dissipates n p C P N.
Proof.
  intros H Structure e. rewrite (structured_term _ _ _ _ _ _ _ Structure). apply both in H. destruct H as [FS H].
  pose proof (semidefinite_correct _ _ _ (added_correct _ _ _ _ _ _ (fits_equals _ _ _ FS)
    (turned_correct _ _ _ _ (fits_equals _ _ _ FS))) H (apply n (real C) e)) as K.
  unfold form in K. rewrite bilinear_plus, bilinear_transpose in K. unfold form. lra.
Qed.

(** [2 y'S y >= q |y|^2] for every output [y = C e]: the fact (13') of a gain with the structure, with its margin q. *)
Theorem accretive_on_outputs n p C S q :
  is_accretive_on_outputs n p C S q = true ->
  forall e : vector, let y := (C * e)%vector in Q2R q * square p y <= 2 * quadratic p S y.
Proof.
  intros H e y. apply both in H. destruct H as [H K]. apply both in H. destruct H as [FC FS]. cbv zeta in K.
  pose proof (semidefinite_correct _ _ _ (times_correct n p n _ _ _ _ (turned_correct _ _ _ _ (fits_equals _ _ _ FC))
    (times_correct p p n _ _ _ _ (subtracted_correct _ _ _ _ _ _ (added_correct _ _ _ _ _ _ (fits_equals _ _ _ FS)
      (turned_correct _ _ _ _ (fits_equals _ _ _ FS))) (multiple_of_identity_correct p q)) (fits_equals _ _ _ FC))) K e)
    as G.
  unfold form in G. rewrite bilinear_transpose_product, bilinear_product, bilinear_minus, bilinear_plus,
    bilinear_transpose,
    bilinear_scale in G.
  fold (form p identity (apply n (real C) e)) in G. rewrite form_identity in G.
  assert (Y : forall j, (j < p)%nat -> y j = apply n (real C) e j).
  { intros j J. apply (times_vector_apply p n); [apply (fits_shape _ _ _ FC)|exact J]. }
  rewrite quadratic_form by apply (fits_shape _ _ _ FS). rewrite (form_ext p _ _ y _ (fun i j _ _ => eq_refl) Y).
  replace (square p y) with (square p (apply n (real C) e)).
  - unfold form. lra.
  - apply sum_ext. intros j J. rewrite Y by exact J. reflexivity.
Qed.

Definition has_accretive_outputs (n p : nat) (C S : list (list Q)) (q : Q) : bool :=
  Qle_bool 0 q &&& is_accretive_on_outputs n p C S q.

Theorem structure_on_outputs_dissipates n p C P S q N :
  has_accretive_outputs n p C S q = true -> has_structure n p C P S N -> dissipates n p C P N.
Proof.
  intros H Structure e. apply both in H. destruct H as [Sign H]. rewrite (structured_term _ _ _ _ _ _ _ Structure).
  pose proof (accretive_on_outputs _ _ _ _ _ H e) as K. cbv zeta in K. apply both in H. destruct H as [H _].
  apply both in H. destruct H as [FC FS].
  assert (Y : forall j, (j < p)%nat -> (C * e)%vector j = apply n (real C) e j).
  { intros j J. apply (times_vector_apply p n); [apply (fits_shape _ _ _ FC)|exact J]. }
  rewrite quadratic_form in K by apply (fits_shape _ _ _ FS).
  rewrite (form_ext p _ _ _ _ (fun i j _ _ => eq_refl) Y) in K.
  apply Qle_bool_iff, Qle_Rle in Sign. rewrite Q2R_zero in Sign. pose proof (square_nonnegative p (C * e)%vector).
  assert (0 <= Q2R q * square p (C * e)%vector) by (apply Rmult_le_pos; assumption). lra.
Qed.

(** With a positive definite P there is a gain N for each S. *)
Theorem structured_gain_exists n p C P S q :
  is_positive q &&& is_at_least n P q = true -> exists N : matrix, has_structure n p C P S N.
Proof.
  intros H. destruct (positive_definite n P q H) as [Positive Definite]. apply both in H. destruct H as [_ H].
  apply both in H. destruct H as [FP _].
  assert (K : forall v, Q2R q * square n v <= form n (real P) v).
  { intros v. rewrite <- quadratic_form by apply (fits_shape _ _ _ FP). apply Definite. }
  set (right := scale (-1) (product p (transpose (real C)) (real S))).
  assert (Columns : forall k, exists N : matrix, same n k (product n (real P) N) right).
  { induction k as [|k [N IH]]; [exists (fun _ _ => 0); intros i j _ J; lia|].
    destruct (positive_definite_solves n (real P) (Q2R q) Positive K (fun i => right i k)) as (x & X).
    exists (fun i j => if Nat.eqb j k then x i else N i j). intros i j I J. unfold product in *.
    destruct (Nat.eqb_spec j k) as [->|D]; [apply X, I|]. apply IH; lia. }
  apply Columns.
Qed.

(** (13') for numbers N exactly as stored, [- (P N C + C'N'P) >= 0]. *)
Definition is_dissipative (n p : nat) (C P N : list (list Q)) (q : Q) : bool :=
  fits p n C &&& fits n n P &&& fits n p N
    &&& (let NC := times n p n (numbers_of n p N) (numbers_of p n C) in
         at_least n (negative n n (added n n (times n n n (numbers_of n n P) NC)
           (times n n n (turned n n NC) (numbers_of n n P)))) q).

(** The fact (13') of certificates, with its margin q. *)
Theorem dissipation n p C P N q :
  is_dissipative n p C P N q = true ->
  forall v : vector, let d := (N * (C * v))%vector in
  inner n v (P * d)%vector + inner n d (P * v)%vector <= - Q2R q * square n v.
Proof.
  intros H v d. apply both in H. destruct H as [H Below]. apply both in H. destruct H as [H FN]. apply both in H.
  destruct H as [FC FP]. cbv zeta in Below.
  pose proof (times_correct n p n _ _ _ _ (fits_equals _ _ _ FN) (fits_equals _ _ _ FC)) as E.
  pose proof (at_least_correct _ _ _ _ (negative_correct _ _ _ _ (added_correct _ _ _ _ _ _
    (times_correct n n n _ _ _ _ (fits_equals _ _ _ FP) E)
    (times_correct n n n _ _ _ _ (turned_correct _ _ _ _ E) (fits_equals _ _ _ FP)))) Below v) as K.
  unfold form in K. rewrite bilinear_scale, bilinear_plus, bilinear_product, bilinear_transpose_product in K.
  assert (D : forall i, (i < n)%nat -> apply n (product p (real N) (real C)) v i = d i).
  { intros i I. unfold d. rewrite apply_product.
    rewrite (times_vector_apply n p N) by (try exact I; apply (fits_shape _ _ _ FN)).
    apply apply_ext; [reflexivity|]. intros j J. symmetry. apply (times_vector_apply p n C); [apply (fits_shape _ _ _
      FC)|
      exact J]. }
  rewrite (bilinear_ext n n (real P) (real P) v _ v d (fun i j _ _ => eq_refl) (fun i _ => eq_refl) D) in K.
  rewrite (bilinear_ext n n (real P) (real P) _ v d v (fun i j _ _ => eq_refl) D (fun i _ => eq_refl)) in K.
  rewrite !inner_bilinear by apply (fits_shape _ _ _ FP). lra.
Qed.

(** Stored numbers that fulfil (13'), with a symmetric P. *)
Definition is_stored_dissipative (n p : nat) (C P N : list (list Q)) (q : Q) : bool :=
  Qle_bool 0 q &&& is_symmetric n (numbers_of n n P) &&& is_dissipative n p C P N q.

Theorem stored_dissipates n p C P N q :
  is_stored_dissipative n p C P N q = true ->
  dissipates n p C P (real N).
Proof.
  intros H e. apply both in H. destruct H as [H D]. apply both in H. destruct H as [Sign Symmetric].
  pose proof (dissipation _ _ _ _ _ _ D e) as K. cbv zeta in K. apply both in D. destruct D as [D _]. apply both in D.
  destruct D as [D FN]. apply both in D. destruct D as [FC FP].
  rewrite !inner_bilinear in K by apply (fits_shape _ _ _ FP).
  rewrite (is_symmetric_correct n _ _ (N * (C * e))%vector e (fits_equals _ _ _ FP) Symmetric) in K.
  apply Qle_bool_iff, Qle_Rle in Sign. rewrite Q2R_zero in Sign. pose proof (square_nonnegative n e).
  assert (0 <= Q2R q * square n e) by (apply Rmult_le_pos; assumption).
  rewrite (bilinear_ext n n (real P) (real P) e _ e (N * (C * e))%vector); [lra|easy|easy|].
  intros i I. rewrite (times_vector_apply n p N) by (try exact I; apply (fits_shape _ _ _ FN)).
  apply apply_ext; [reflexivity|]. intros j J. symmetry. apply (times_vector_apply p n C); [apply (fits_shape _ _ _ FC)|
    exact J].
Qed.

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

(** ** (13') is false *)

(** [y'(S + S')y < 0] for an output y = C v. *)
Theorem not_accretive_on_outputs n p C S v :
  fits p n C &&& fits p p S
    &&& (let both := added p p (numbers_of p p S) (turned p p (numbers_of p p S)) in
         is_witness true n (times n p n (turned n p (numbers_of p n C)) (times p p n both (numbers_of p n C))) v) =
           true ->
  exists v : vector, let y := (C * v)%vector in 2 * quadratic p S y < 0.
Proof.
  intros H. apply both in H. destruct H as [H K]. apply both in H. destruct H as [FC FS]. cbv zeta in K.
  destruct (is_witness_correct _ _ _ _ _ (times_correct n p n _ _ _ _ (turned_correct _ _ _ _ (fits_equals _ _ _ FC))
    (times_correct p p n _ _ _ _ (added_correct _ _ _ _ _ _ (fits_equals _ _ _ FS)
      (turned_correct _ _ _ _ (fits_equals _ _ _ FS))) (fits_equals _ _ _ FC))) K) as (_ & _ & G).
  specialize (G eq_refl). exists (column v). intros y.
  unfold form in G. rewrite bilinear_transpose_product, bilinear_product, bilinear_plus, bilinear_transpose in G.
  assert (Y : forall j, (j < p)%nat -> y j = apply n (real C) (column v) j).
  { intros j J. apply (times_vector_apply p n); [apply (fits_shape _ _ _ FC)|exact J]. }
  rewrite quadratic_form by apply (fits_shape _ _ _ FS). rewrite (form_ext p _ _ y _ (fun i j _ _ => eq_refl) Y).
  unfold form. lra.
Qed.

(** [v'(P N C + C'N'P)v > 0]. *)
Theorem not_dissipative n p C P N v :
  fits p n C &&& fits n n P &&& fits n p N
    &&& (let NC := times n p n (numbers_of n p N) (numbers_of p n C) in
         is_witness true n (negative n n (added n n (times n n n (numbers_of n n P) NC)
           (times n n n (turned n n NC) (numbers_of n n P)))) v) = true ->
  exists v : vector, let d := (N * (C * v))%vector in
  0 < inner n v (P * d)%vector + inner n d (P * v)%vector.
Proof.
  intros H. apply both in H. destruct H as [H K]. apply both in H. destruct H as [H FN]. apply both in H.
  destruct H as [FC FP]. cbv zeta in K.
  pose proof (times_correct n p n _ _ _ _ (fits_equals _ _ _ FN) (fits_equals _ _ _ FC)) as E.
  destruct (is_witness_correct _ _ _ _ _ (negative_correct _ _ _ _ (added_correct _ _ _ _ _ _
    (times_correct n n n _ _ _ _ (fits_equals _ _ _ FP) E)
    (times_correct n n n _ _ _ _ (turned_correct _ _ _ _ E) (fits_equals _ _ _ FP)))) K) as (_ & _ & G).
  specialize (G eq_refl). exists (column v). intros d. set (x := column v) in *.
  unfold form in G. rewrite bilinear_scale, bilinear_plus, bilinear_product, bilinear_transpose_product in G.
  assert (D : forall i, (i < n)%nat -> apply n (product p (real N) (real C)) x i = d i).
  { intros i I. unfold d. rewrite apply_product.
    rewrite (times_vector_apply n p N) by (try exact I; apply (fits_shape _ _ _ FN)).
    apply apply_ext; [reflexivity|]. intros j J. symmetry. apply (times_vector_apply p n C); [apply (fits_shape _ _ _
      FC)|
      exact J]. }
  rewrite (bilinear_ext n n (real P) (real P) x _ x d (fun i j _ _ => eq_refl) (fun i _ => eq_refl) D) in G.
  rewrite (bilinear_ext n n (real P) (real P) _ x d x (fun i j _ _ => eq_refl) D (fun i _ => eq_refl)) in G.
  rewrite !inner_bilinear by apply (fits_shape _ _ _ FP). lra.
Qed.
