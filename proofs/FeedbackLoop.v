(** The cubic observer in the loop [u = -K xhat]: the theorem [feedback-loop] of certificates (Theorem 6 and Corollary 1
    of the cubic paper, with (13')).

    With [e = x - xhat] the loop is [x' = (A - B K)x + B K e], [e' = F e + (y'theta y) N y], [y = C e], [F = A - L C].
    If [e'P N C e <= 0], as with [P N = -C'S], [S + S' >= 0], and [theta >= 0], the cubic term adds nothing positive to
    the derivative of [W = x'P1 x + e'Pe], and what is left is (25),
    [[He((A - BK)'P1) + 2 a P1, P1 B K; *, He(F'P) + 2 a P] <= 0]: W falls at the rate a. *)

From Coq Require Import Reals QArith Qreals ZArith List Lra Lia.
From Luenberger Require Import Vectors Definite Inequalities Decay LinearObserver CubicObserver Blocks Refuted.
Import ListNotations.
Local Open Scope R_scope.
Local Open Scope lazy_bool_scope.

(** The Euclidean norm of a pair of vectors, [(|x|^2 + |e|^2)^(1/2)]. *)
Definition norm_of_pair (n : nat) (x e : vector) : R := sqrt (square n x + square n e).

(** ** The inequality (25) *)

(** [[A - BK, BK; 0, A - LC]], and [[P1, 0; 0, P]]. *)
Definition loop_numbers (n m p : nat) (A B C K L : list (list Q)) : numbers :=
  in_blocks n n (error_numbers n m A K B) (times n m n (numbers_of n m B) (numbers_of m n K)) no_numbers
    (error_numbers n p A C L).

Definition loop_matrix (n m p : nat) (A B C K L : list (list Q)) : matrix :=
  blocks n (error_matrix m A K B) (product m (real B) (real K)) nothing (error_matrix p A C L).

Definition both_numbers (n : nat) (P1 P : list (list Q)) : numbers :=
  in_blocks n n (numbers_of n n P1) no_numbers no_numbers (numbers_of n n P).

Definition both_matrix (n : nat) (P1 P : list (list Q)) : matrix := blocks n (real P1) nothing nothing (real P).

Definition loop_fits (n m p : nat) (A B C K L P1 P : list (list Q)) : bool :=
  linear_fits n p A C L P &&& linear_fits n m A K B P1.

Definition loop_falls (n m p : nat) (A B C K L P1 P : list (list Q)) (rate q : Q) : bool :=
  loop_fits n m p A B C K L P1 P
    &&& at_least (n + n) (negative (n + n) (n + n)
          (lyapunov_numbers (n + n) (loop_numbers n m p A B C K L) (both_numbers n P1 P) rate)) q.

Lemma loop_numbers_correct n m p A B C K L P1 P rate :
  loop_fits n m p A B C K L P1 P = true ->
  equals (n + n) (n + n) (lyapunov_numbers (n + n) (loop_numbers n m p A B C K L) (both_numbers n P1 P) rate)
    (lyapunov_matrix (n + n) (loop_matrix n m p A B C K L) (both_matrix n P1 P) (Q2R rate)).
Proof.
  intros Fit. apply both in Fit. destruct Fit as [Fit1 Fit2].
  destruct (linear_fits_parts _ _ _ _ _ _ Fit1) as (FA & FC & FL & FP).
  destruct (linear_fits_parts _ _ _ _ _ _ Fit2) as (_ & FK & FB & FP1).
  apply lyapunov_numbers_correct.
  - apply in_blocks_correct; [apply error_numbers_correct; assumption|apply times_correct; apply fits_equals;
    assumption|
      apply no_numbers_correct|apply error_numbers_correct; assumption].
  - apply in_blocks_correct; try apply no_numbers_correct; apply fits_equals; assumption.
Qed.

(** The form of (25) at (v, w), with the matrices of the certificate. *)
Lemma loop_form n m p A B C K L P1 P rate (v w : vector) :
  loop_fits n m p A B C K L P1 P = true ->
  let f := (A * v - B * (K * v) + B * (K * w))%vector in
  let g := (A * w - L * (C * w))%vector in
  form (n + n) (lyapunov_matrix (n + n) (loop_matrix n m p A B C K L) (both_matrix n P1 P) rate) (pair_of n v w)
  = inner n f (P1 * v)%vector + inner n v (P1 * f)%vector + inner n g (P * w)%vector + inner n w (P * g)%vector
    + 2 * rate * (quadratic n P1 v + quadratic n P w).
Proof.
  intros Fit f g. apply both in Fit. destruct Fit as [Fit1 Fit2].
  destruct (linear_fits_parts _ _ _ _ _ _ Fit1) as (FA & FC & FL & FP).
  destruct (linear_fits_parts _ _ _ _ _ _ Fit2) as (_ & FK & FB & FP1).
  rewrite lyapunov_form. set (z := pair_of n v w).
  assert (Flow : forall i, (i < n + n)%nat -> apply (n + n) (loop_matrix n m p A B C K L) z i = pair_of n f g i).
  { apply each_of_pair; intros i I; unfold z, loop_matrix.
    - rewrite apply_blocks_first, pair_first by exact I. unfold f. unfold plus_vector at 1.
      rewrite (error_apply n m) by (try exact I; eapply fits_shape; eassumption). f_equal.
      rewrite apply_product, (times_vector_apply n m) by (try exact I; eapply fits_shape; eassumption).
      apply apply_ext; [reflexivity|]. intros j J. symmetry. apply (times_vector_apply m); [eapply fits_shape;
        eassumption|
        exact J].
    - rewrite apply_blocks_second, pair_second. unfold g.
      rewrite (error_apply n p) by (try exact I; eapply fits_shape; eassumption).
      unfold apply at 1, nothing. rewrite (sum_ext n _ (fun _ => 0)), sum_zero by (intros; ring). ring. }
  rewrite (bilinear_ext _ _ (both_matrix n P1 P) (both_matrix n P1 P) _ z (pair_of n f g) z) by easy.
  rewrite (bilinear_ext _ _ (both_matrix n P1 P) (both_matrix n P1 P) z _ z (pair_of n f g)) by easy.
  unfold form, z, both_matrix. rewrite !bilinear_blocks, !bilinear_nothing.
  rewrite !inner_bilinear, !quadratic_form by (eapply fits_shape; eassumption). unfold form. ring.
Qed.

(** The fact (25) of certificates, with its margin q. *)
Theorem loop_inequality n m p A B C K L P1 P q :
  is_positive q &&& loop_falls n m p A B C K L P1 P 0 q = true ->
  0 < Q2R q /\ forall v w : vector,
  let f := (A * v - B * (K * v) + B * (K * w))%vector in
  let g := (A * w - L * (C * w))%vector in
  inner n f (P1 * v)%vector + inner n v (P1 * f)%vector + inner n g (P * w)%vector + inner n w (P * g)%vector
    <= - Q2R q * (square n v + square n w).
Proof.
  intros H. apply both in H. destruct H as [Positive H]. split; [apply is_positive_correct, Positive|].
  intros v w f g. apply both in H. destruct H as [Fit H].
  pose proof (at_least_correct _ _ _ _ (negative_correct _ _ _ _ (loop_numbers_correct _ _ _ _ _ _ _ _ _ _ 0 Fit)) H
    (pair_of n v w)) as R.
  unfold form in R at 1. rewrite bilinear_scale in R. fold (form (n + n) (lyapunov_matrix (n + n)
    (loop_matrix n m p A B C K L) (both_matrix n P1 P) (Q2R 0)) (pair_of n v w)) in R.
  rewrite square_pair, loop_form, Q2R_zero in R by exact Fit. fold f g in R. lra.
Qed.

(** (25) is false: a vector of 2n entries that shows it. *)
Theorem no_loop_inequality n m p A B C K L P1 P z :
  loop_fits n m p A B C K L P1 P
    &&& is_witness false (n + n) (negative (n + n) (n + n)
          (lyapunov_numbers (n + n) (loop_numbers n m p A B C K L) (both_numbers n P1 P) 0)) z = true ->
  exists v w : vector, 0 < square n v + square n w /\
    let f := (A * v - B * (K * v) + B * (K * w))%vector in
    let g := (A * w - L * (C * w))%vector in
    0 <= inner n f (P1 * v)%vector + inner n v (P1 * f)%vector + inner n g (P * w)%vector + inner n w (P * g)%vector.
Proof.
  intros H. apply both in H. destruct H as [Fit H].
  destruct (is_witness_correct _ _ _ _ _ (negative_correct _ _ _ _ (loop_numbers_correct _ _ _ _ _ _ _ _ _ _ 0 Fit)) H)
    as (N & R & _).
  set (v := column z) in *. set (w := (fun i => v (n + i)%nat) : vector).
  assert (E : forall i, (i < n + n)%nat -> v i = pair_of n v w i).
  { apply each_of_pair; intros i I; [rewrite pair_first by exact I|rewrite pair_second]; reflexivity. }
  exists v, w. split.
  - rewrite <- square_pair. rewrite <- form_identity in N |- *. rewrite <- (form_ext (n + n) identity identity v) by
    easy.
    exact N.
  - intros f g. unfold form in R. rewrite bilinear_scale in R.
    rewrite (bilinear_ext _ _ _ _ v v (pair_of n v w) (pair_of n v w) (fun i j _ _ => eq_refl) E E) in R.
    fold (form (n + n) (lyapunov_matrix (n + n) (loop_matrix n m p A B C K L) (both_matrix n P1 P) (Q2R 0))
      (pair_of n v w)) in R.
    rewrite loop_form, Q2R_zero in R by exact Fit. fold f g in R. lra.
Qed.

(** ** The loop in x and e *)

(** [(A - B K)x + B K e] *)
Definition loop_flow (A B K : list (list Q)) (x e : vector) : vector := (A * x - B * (K * x) + B * (K * e))%vector.

Section Flow.
  Variables (n m p : nat) (A B C K L theta : list (list Q)).
  Hypothesis HA : has_shape n n A = true.
  Hypothesis HB : has_shape n m B = true.
  Hypothesis HC : has_shape p n C = true.
  Hypothesis HK : has_shape m n K = true.
  Hypothesis HL : has_shape n p L = true.
  Hypothesis Htheta : has_shape p p theta = true.

  (** The plant, with the error in place of the state of the observer. *)
  Lemma plant_in_loop (x xhat : vector) i : (i < n)%nat ->
    (A * x - B * (K * xhat))%vector i = loop_flow A B K x (x - xhat)%vector i.
  Proof.
    intros I. unfold loop_flow, plus_vector, minus_vector at 1 2.
    rewrite !(times_vector_apply n m B) by assumption.
    rewrite (apply_ext m (real B) (real B) (K * xhat)%vector
      (fun j => apply n (real K) x j - apply n (real K) (x - xhat)%vector j) i); [|reflexivity|].
    - rewrite apply_minus_vector.
      rewrite (apply_ext m (real B) (real B) (K * x)%vector (apply n (real K) x) i)
        by (try reflexivity; intros j J; apply (times_vector_apply m n K); assumption).
      rewrite (apply_ext m (real B) (real B) (K * (x - xhat))%vector (apply n (real K) (x - xhat)%vector) i)
        by (try reflexivity; intros j J; apply (times_vector_apply m n K); assumption).
      ring.
    - intros j J. rewrite (times_vector_apply m n K) by assumption. unfold minus_vector.
      rewrite apply_minus_vector. ring.
  Qed.

  (** The difference of plant and observer. *)
  Lemma error_in_loop N (x xhat : vector) i : (i < n)%nat ->
    (A * x - B * (K * xhat))%vector i
      - (let r := (C * x - C * xhat)%vector in
         A * xhat - B * (K * xhat) + L * r - quadratic p theta r .* apply p N r)%vector i
    = cubic_error p A C L theta N (x - xhat)%vector i.
  Proof.
    intros I. cbv zeta. set (r := (C * x - C * xhat)%vector). set (e := (x - xhat)%vector).
    assert (Y : forall j, (j < p)%nat -> r j = (C * e)%vector j).
    { intros j J. unfold r, e, minus_vector. rewrite !(times_vector_apply p n C) by assumption.
      symmetry. apply apply_minus_vector. }
    assert (Q : quadratic p theta (C * e)%vector = quadratic p theta r).
    { rewrite !quadratic_form by exact Htheta. apply form_ext; [easy|]. intros j J. symmetry. apply Y, J. }
    assert (D : apply p N (C * e)%vector i = apply p N r i).
    { apply apply_ext; [reflexivity|]. intros j J. symmetry. apply Y, J. }
    assert (G : (L * (C * e))%vector i = (L * r)%vector i).
    { rewrite !(times_vector_apply n p L) by assumption. apply apply_ext; [reflexivity|]. intros j J. symmetry.
      apply Y, J. }
    assert (F : (A * e)%vector i = (A * x)%vector i - (A * xhat)%vector i).
    { unfold e. rewrite !(times_vector_apply n n A) by assumption. apply apply_minus_vector. }
    unfold cubic_error, plus_vector, minus_vector, scale_vector in *. rewrite Q, D, G, F. ring.
  Qed.

  (** Solutions of plant and observer, as ones in x and e. *)
  Lemma loop_solution N T (x xhat : R -> vector) :
    solution T n x (fun t => A * x t - B * (K * xhat t))%vector ->
    solution T n xhat (fun t => let r := (C * x t - C * xhat t)%vector in
      (A * xhat t - B * (K * xhat t) + L * r - quadratic p theta r .* apply p N r)%vector) ->
    solution T n x (fun t => loop_flow A B K (x t) (x t - xhat t)%vector)
    /\ solution T n (fun t => x t - xhat t)%vector (fun t => cubic_error p A C L theta N (x t - xhat t)%vector).
  Proof.
    intros Plant Observer. split.
    - apply (solution_ext T n x (fun t => A * x t - B * (K * xhat t))%vector); [|exact Plant].
      intros t i I. apply plant_in_loop, I.
    - refine (solution_ext T n _ (fun t i => (A * x t - B * (K * xhat t))%vector i - _ t i) _ _
        (solution_difference T n x xhat _ _ Plant Observer)).
      intros t i I. apply error_in_loop, I.
  Qed.
End Flow.

(** Two solutions as one of the pair. *)
Lemma pair_solution T n (x e f g : R -> vector) :
  solution T n x f -> solution T n e g ->
  solution T (n + n) (fun t => pair_of n (x t) (e t)) (fun t => pair_of n (f t) (g t)).
Proof.
  intros X E. unfold solution. apply each_of_pair; intros i I.
  - destruct (X i I) as [Cont D]. split.
    + intros eps He. destruct (Cont eps He) as (d & Hd & R). exists d. split; [exact Hd|]. intros t Ht.
      rewrite !pair_first by exact I. apply R, Ht.
    + intros t Ht. rewrite pair_first by exact I. specialize (D t Ht). intros eps He. destruct (D eps He) as (d & R).
      exists d. intros h Hh L'. rewrite !pair_first by exact I. apply R; assumption.
  - destruct (E i I) as [Cont D]. split.
    + intros eps He. destruct (Cont eps He) as (d & Hd & R). exists d. split; [exact Hd|]. intros t Ht.
      rewrite !pair_second. apply R, Ht.
    + intros t Ht. rewrite pair_second. specialize (D t Ht). intros eps He. destruct (D eps He) as (d & R).
      exists d. intros h Hh L'. rewrite !pair_second. apply R; assumption.
Qed.

Lemma pair_form n P1 P v w : has_shape n n P1 = true -> has_shape n n P = true ->
  form (n + n) (both_matrix n P1 P) (pair_of n v w) = quadratic n P1 v + quadratic n P w.
Proof.
  intros HP1 HP. unfold form, both_matrix. rewrite bilinear_blocks, !bilinear_nothing.
  rewrite !quadratic_form by assumption. unfold form. ring.
Qed.

(** ** The statement about trajectories *)

(** What the cubic observer needs, bounds of P1, and (25). *)
Definition loop_decays (n m p : nat) (A B C K L P1 P theta : list (list Q)) (a lower upper overshoot : Q) : bool :=
  cubic_decays n p A C L P theta a lower upper overshoot
    &&& is_between n P1 lower upper overshoot &&& loop_falls n m p A B C K L P1 P a 0.

Section Loop.
  Variables (n m p : nat) (A B C K L P1 P theta : list (list Q)) (a lower upper overshoot : Q).
  Hypothesis Checked : loop_decays n m p A B C K L P1 P theta a lower upper overshoot = true.
  Variable N : matrix.
  Hypothesis Dissipates : dissipates n p C P N.

  Lemma loop_parts :
    is_between n P lower upper overshoot = true /\ is_between n P1 lower upper overshoot = true
    /\ has_shape n n A = true /\ has_shape n m B = true /\ has_shape p n C = true /\ has_shape m n K = true
    /\ has_shape n p L = true /\ has_shape p p theta = true /\ has_shape n n P1 = true /\ has_shape n n P = true.
  Proof.
    pose proof (both _ _ Checked) as [H Falls]. pose proof (both _ _ H) as [Cubic Between1].
    destruct (cubic_parts _ _ _ _ _ _ _ _ _ _ _ Cubic) as (Decays & _ & _ & ShapeTheta).
    destruct (shapes _ _ _ _ _ _ _ _ _ _ Decays) as (HA & HC & HL & HP).
    pose proof (both _ _ Decays) as [Between _].
    pose proof (both _ _ Falls) as [Fit _]. pose proof (both _ _ Fit) as [_ Fit2].
    destruct (linear_fits_parts _ _ _ _ _ _ Fit2) as (_ & FK & FB & FP1).
    pose proof (fits_shape _ _ _ FK). pose proof (fits_shape _ _ _ FB). pose proof (fits_shape _ _ _ FP1).
    repeat split; assumption.
  Qed.

  (** W falls at every (v, w). *)
  Lemma loop_flow_falls v w :
    let z := pair_of n v w in
    let f := pair_of n (loop_flow A B K v w) (cubic_error p A C L theta N w) in
    bilinear (n + n) (n + n) (both_matrix n P1 P) f z + bilinear (n + n) (n + n) (both_matrix n P1 P) z f
      + 2 * Q2R a * form (n + n) (both_matrix n P1 P) z <= 0.
  Proof.
    intros z f. unfold z, f. clear z f.
    destruct loop_parts as (_ & _ & HA & HB & HC & HK & HL & ShapeTheta & HP1 & HP).
    pose proof (both _ _ Checked) as [H Falls]. pose proof (both _ _ H) as [Cubic _].
    destruct (cubic_parts _ _ _ _ _ _ _ _ _ _ _ Cubic) as (_ & Symmetric & Theta & _).
    pose proof (both _ _ Falls) as [Fit Below].
    pose proof (at_least_correct _ _ _ _ (negative_correct _ _ _ _ (loop_numbers_correct _ _ _ _ _ _ _ _ _ _ a Fit))
      Below (pair_of n v w)) as R.
    unfold form in R at 1. rewrite bilinear_scale in R. fold (form (n + n) (lyapunov_matrix (n + n)
      (loop_matrix n m p A B C K L) (both_matrix n P1 P) (Q2R a)) (pair_of n v w)) in R.
    rewrite loop_form, Q2R_zero in R by exact Fit. fold (loop_flow A B K v w) in R.
    rewrite pair_form by assumption. unfold both_matrix. rewrite !bilinear_blocks, !bilinear_nothing.
    set (g := cubic_error p A C L theta N w). set (h := (A * w - L * (C * w))%vector) in R.
    set (c := quadratic p theta (C * w)%vector). set (d := apply p N (C * w)%vector).
    assert (Split : forall i, (i < n)%nat -> g i = h i + c * d i) by reflexivity.
    rewrite (bilinear_ext n n (real P) (real P) g w (fun i => h i + c * d i) w) by (try exact Split; easy).
    rewrite (bilinear_ext n n (real P) (real P) w g w (fun i => h i + c * d i)) by (try exact Split; easy).
    rewrite (bilinear_plus_left n n _ h (fun i => c * d i)), bilinear_scale_left.
    rewrite (bilinear_plus_right n n _ _ h (fun i => c * d i)), bilinear_scale_right.
    rewrite (Symmetric d w).
    rewrite !inner_bilinear in R by assumption.
    assert (Y : forall j, (j < p)%nat -> (C * w)%vector j = apply n (real C) w j).
    { intros j J. apply (times_vector_apply p); assumption. }
    assert (Term : bilinear n n (real P) w d <= 0).
    { rewrite (bilinear_ext n n (real P) (real P) w d w (apply p N (apply n (real C) w)));
        [apply Dissipates|easy|easy|]. intros i _. apply apply_ext; [reflexivity|exact Y]. }
    assert (0 <= c) by (unfold c; rewrite quadratic_form by exact ShapeTheta; apply Theta).
    assert (0 <= c * - bilinear n n (real P) w d) by (apply Rmult_le_pos; lra).
    lra.
  Qed.

  Theorem loop_decay (T : R) (x xhat : R -> vector) :
    solution T n x (fun t => A * x t - B * (K * xhat t))%vector ->
    solution T n xhat (fun t => let r := (C * x t - C * xhat t)%vector in
      (A * xhat t - B * (K * xhat t) + L * r - quadratic p theta r .* apply p N r)%vector) ->
    let e t := (x t - xhat t)%vector in
    (forall s t, 0 <= s -> s <= t -> t < T ->
      quadratic n P1 (x t) + quadratic n P (e t)
        <= exp (- (2 * Q2R a) * (t - s)) * (quadratic n P1 (x s) + quadratic n P (e s)))
    /\ (forall t, 0 <= t -> t < T ->
      norm_of_pair n (x t) (e t) <= Q2R overshoot * exp (- Q2R a * t) * norm_of_pair n (x 0) (e 0)).
  Proof.
    intros Plant Observer e.
    destruct loop_parts as (Between & Between1 & HA & HB & HC & HK & HL & Htheta & HP1 & HP).
    destruct (loop_solution n m p A B C K L theta HA HB HC HK HL Htheta N T x xhat Plant Observer) as [X E].
    pose proof (pair_solution T n x e _ _ X E) as Z.
    assert (V : forall s t, 0 <= s -> s <= t -> t < T ->
      quadratic n P1 (x t) + quadratic n P (e t)
        <= exp (- (2 * Q2R a) * (t - s)) * (quadratic n P1 (x s) + quadratic n P (e s))).
    { intros s t Hs Hst Ht. rewrite <- !(pair_form n P1 P) by assumption.
      apply (lyapunov_decay (n + n) (both_matrix n P1 P) (Q2R a) T (fun t => pair_of n (x t) (e t)) _ Z);
        try assumption.
      intros r _. apply loop_flow_falls. }
    split; [exact V|]. intros t Hs Ht.
    destruct (between_numbers _ _ _ _ _ Between) as (Positive & Sign & Big).
    specialize (V 0 t (Rle_refl 0) Hs Ht). rewrite Rminus_0_r in V.
    apply (root_of_bound (Q2R lower) (Q2R upper) (Q2R overshoot) (exp (- Q2R a * t))
      (quadratic n P1 (x t) + quadratic n P (e t)) (quadratic n P1 (x 0) + quadratic n P (e 0))); try assumption.
    - apply Rlt_le, exp_pos.
    - apply Rplus_le_le_0_compat; apply square_nonnegative.
    - apply Rplus_le_le_0_compat; apply square_nonnegative.
    - rewrite !quadratic_form by assumption. pose proof (between_lower _ _ _ _ _ Between1 (x t)).
      pose proof (between_lower _ _ _ _ _ Between (e t)). lra.
    - replace (exp (- Q2R a * t) * exp (- Q2R a * t)) with (exp (- (2 * Q2R a) * t)); [exact V|].
      rewrite <- exp_plus. f_equal. ring.
    - rewrite !quadratic_form by assumption. pose proof (between_upper _ _ _ _ _ Between1 (x 0)).
      pose proof (between_upper _ _ _ _ _ Between (e 0)). lra.
  Qed.
End Loop.
