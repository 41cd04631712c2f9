(** The sampled cubic observer: the theorem [sampled-cubic-observer] of certificates.

    For the sampled plant [x(k+1) = A x(k) + B u(k)], [y = C x] and the observer
    [xhat(k+1) = A (xhat - g N z) + B u + r L z], [z = y - C xhat], [q = max(z'theta z, 0)],
    [r = 1/sqrt(1 + 2 w h q)], [g = (1 - r)/w], the error [e = x - xhat] obeys [e(k+1) = M(g) e(k)] with
    [M(g) = A - L C + g (A N + w L) C] and [0 <= g < 1/w], whatever theta is. M(g) is the mean of [M(0) = A - L C] and
    [M(1/w) = A + A N C / w] with the weights [1 - w g] and [w g], and [v'Pv] is convex: where V falls by [factor^2]
      with
    both, it does with M(g). The statement is about the exact step. *)

From Coq Require Import Reals QArith Qreals ZArith List Lra Lia.
From Luenberger Require Import Vectors Definite Inequalities DiscreteObserver Refuted.
Import ListNotations.
Local Open Scope R_scope.
Local Open Scope lazy_bool_scope.

(** ** The inequality at the other end *)

(** [w A + A N C] *)
Definition end_numbers (n p : nat) (A C N : list (list Q)) (w : Q) : numbers :=
  added n n (multiple n n w (numbers_of n n A))
    (times n n n (numbers_of n n A) (times n p n (numbers_of n p N) (numbers_of p n C))).

Definition end_matrix (n p : nat) (A C N : list (list Q)) (w : R) : matrix :=
  plus (scale w (real A)) (product n (real A) (product p (real N) (real C))).

Lemma end_numbers_correct n p A C N w :
  fits n n A = true -> fits p n C = true -> fits n p N = true ->
  equals n n (end_numbers n p A C N w) (end_matrix n p A C N (Q2R w)).
Proof.
  intros FA FC FN. apply added_correct; [apply multiple_correct, fits_equals, FA|].
  apply times_correct; [apply fits_equals, FA|]. apply times_correct; apply fits_equals; assumption.
Qed.

(** [w A v + A (N (C v))] *)
Lemma end_apply n p A C N w (v : vector) i :
  has_shape n n A = true -> has_shape p n C = true -> has_shape n p N = true -> (i < n)%nat ->
  (w .* (A * v) + A * (N * (C * v)))%vector i = apply n (end_matrix n p A C N w) v i.
Proof.
  intros HA HC HN I. unfold end_matrix, plus_vector, scale_vector. rewrite apply_plus, apply_product.
  rewrite !(times_vector_apply n n A) by assumption. f_equal.
  - unfold apply, scale. rewrite <- sum_times. apply sum_ext. intros; ring.
  - apply apply_ext; [reflexivity|]. intros j J. rewrite apply_product, (times_vector_apply n p N) by assumption.
    apply apply_ext; [reflexivity|]. intros l K. apply (times_vector_apply p n C); assumption.
Qed.

(** [G'P G - (factor w)^2 P <= - q I], [G = w A + A N C]. *)
Definition end_shrinks (n p : nat) (A C N P : list (list Q)) (w factor q : Q) : bool :=
  fits n n A &&& fits p n C &&& fits n p N &&& fits n n P
    &&& at_least n (negative n n (stein_numbers n (end_numbers n p A C N w) (numbers_of n n P) (factor * w))) q.

Lemma end_parts n p A C N P w factor q : end_shrinks n p A C N P w factor q = true ->
  fits n n A = true /\ fits p n C = true /\ fits n p N = true /\ fits n n P = true
  /\ at_least n (negative n n (stein_numbers n (end_numbers n p A C N w) (numbers_of n n P) (factor * w))) q = true.
Proof.
  unfold end_shrinks. destruct (fits n n A), (fits p n C), (fits n p N), (fits n n P); try discriminate. intros H.
  repeat split. exact H.
Qed.

Lemma end_form n p A C N P w factor q :
  end_shrinks n p A C N P w factor q = true ->
  forall v, form n (real P) (apply n (end_matrix n p A C N (Q2R w)) v)
    - Q2R factor ^ 2 * Q2R w ^ 2 * form n (real P) v <= - Q2R q * square n v.
Proof.
  intros H v. destruct (end_parts _ _ _ _ _ _ _ _ _ H) as (FA & FC & FN & FP & Below).
  pose proof (at_least_correct _ _ _ _ (negative_correct _ _ _ _ (stein_numbers_correct _ _ _ (factor * w) _ _
    (end_numbers_correct _ _ _ _ _ w FA FC FN) (fits_equals _ _ _ FP))) Below v) as K.
  unfold form in K at 1. rewrite bilinear_scale in K.
  fold (form n (stein_matrix n (end_matrix n p A C N (Q2R w)) (real P) (Q2R (factor * w))) v) in K.
  rewrite stein_form, Q2R_mult in K. lra.
Qed.

(** [G v], with the matrices of the certificate, in a form. *)
Lemma end_quadratic n p A C N P (w c : R) (v : vector) :
  fits n n A = true -> fits p n C = true -> fits n p N = true -> fits n n P = true ->
  quadratic n P (w .* (A * v) + A * (N * (C * v)))%vector - c * quadratic n P v
  = form n (real P) (apply n (end_matrix n p A C N w) v) - c * form n (real P) v.
Proof.
  intros FA FC FN FP. rewrite !quadratic_form by apply (fits_shape _ _ _ FP). f_equal. apply form_ext; [easy|].
  intros i I. apply (end_apply n p); try exact I; eapply fits_shape; eassumption.
Qed.

(** The third fact of [sampled-cubic-observer], [(w A + A N C)'P(w A + A N C) - w^2 P < 0], with its margin q. *)
Theorem end_inequality n p A C N P w q :
  is_positive q &&& end_shrinks n p A C N P w 1 q = true ->
  0 < Q2R q /\ forall v : vector, let f := (Q2R w .* (A * v) + A * (N * (C * v)))%vector in
  quadratic n P f - Q2R w ^ 2 * quadratic n P v <= - Q2R q * square n v.
Proof.
  intros H. apply both in H. destruct H as [Positive H]. split; [apply is_positive_correct, Positive|].
  intros v f. destruct (end_parts _ _ _ _ _ _ _ _ _ H) as (FA & FC & FN & FP & _). unfold f.
  rewrite (end_quadratic n p) by assumption. pose proof (end_form _ _ _ _ _ _ _ _ _ H v) as K.
  replace (Q2R 1) with 1 in K by (unfold Q2R; simpl; lra). lra.
Qed.

(** [(w A + A N C)'P(w A + A N C) - w^2 P] is not negative definite. *)
Theorem no_end_inequality n p A C N P w v :
  fits n n A &&& fits p n C &&& fits n p N &&& fits n n P
    &&& is_witness false n (negative n n (stein_numbers n (end_numbers n p A C N w) (numbers_of n n P) w)) v = true ->
  exists v : vector, 0 < square n v /\
    let f := (Q2R w .* (A * v) + A * (N * (C * v)))%vector in 0 <= quadratic n P f - Q2R w ^ 2 * quadratic n P v.
Proof.
  intros H. apply both in H. destruct H as [H Witness]. apply both in H. destruct H as [H FP]. apply both in H.
  destruct H as [H FN]. apply both in H. destruct H as [FA FC].
  destruct (is_witness_correct _ _ _ _ _ (negative_correct _ _ _ _ (stein_numbers_correct _ _ _ w _ _
    (end_numbers_correct _ _ _ _ _ w FA FC FN) (fits_equals _ _ _ FP))) Witness) as (Nonzero & K & _).
  exists (column v). split; [exact Nonzero|]. intros f. unfold f. rewrite (end_quadratic n p) by assumption.
  unfold form in K. rewrite bilinear_scale in K. fold (form n (stein_matrix n (end_matrix n p A C N (Q2R w)) (real P)
    (Q2R w)) (column v)) in K. rewrite stein_form in K. lra.
Qed.

(** ** Convexity *)

(** [V((1 - s)f + s g) <= (1 - s)V(f) + s V(g)] for [0 <= s <= 1] and a form without negative values. *)
Lemma form_convex n P s (f g : vector) :
  (forall v, 0 <= form n P v) -> 0 <= s <= 1 ->
  form n P (fun i => (1 - s) * f i + s * g i) <= (1 - s) * form n P f + s * form n P g.
Proof.
  intros Positive Hs. pose proof (Positive (fun i => f i + (-1) * g i)) as K. unfold form in *.
  rewrite (bilinear_plus_left n n P f (fun i => (-1) * g i)), bilinear_scale_left in K.
  rewrite !(bilinear_plus_right n n P _ f (fun i => (-1) * g i)), !bilinear_scale_right in K.
  rewrite (bilinear_plus_left n n P (fun i => (1 - s) * f i) (fun i => s * g i)), !bilinear_scale_left.
  rewrite !(bilinear_plus_right n n P _ (fun i => (1 - s) * f i) (fun i => s * g i)), !bilinear_scale_right.
  assert (0 <= s * (1 - s)) by (apply Rmult_le_pos; lra).
  assert (0 <= s * (1 - s) * (bilinear n n P f f + -1 * bilinear n n P f g
    + -1 * (bilinear n n P g f + -1 * bilinear n n P g g))) by (apply Rmult_le_pos; assumption).
  lra.
Qed.

(** ** The statement about trajectories *)

Definition sampled_contracts (n p : nat) (A C L N P : list (list Q)) (w factor lower upper overshoot : Q) : bool :=
  contracts n p A C L P factor lower upper overshoot &&& is_positive w &&& end_shrinks n p A C N P w factor 0.

(** [r = 1/sqrt(1 + 2 w h q)], [q = max(z'theta z, 0)], and [g = (1 - r)/w]. *)
Definition damping (p : nat) (theta : list (list Q)) (w h : R) (z : vector) : R :=
  / sqrt (1 + 2 * w * h * Rmax (quadratic p theta z) 0).

Section Error.
  Variables (n p : nat) (A C L N P : list (list Q)) (w factor lower upper overshoot : Q).
  Hypothesis Checked : sampled_contracts n p A C L N P w factor lower upper overshoot = true.

  (** [M(g) e] falls by [factor^2], for all g between. *)
  Lemma mean_shrinks (g : R) (e : vector) :
    0 <= g -> Q2R w * g <= 1 ->
    form n (real P) (fun i => (A * e - L * (C * e) + g .* (A * (N * (C * e)) + Q2R w .* (L * (C * e))))%vector i)
    <= Q2R factor * Q2R factor * form n (real P) e.
  Proof.
    intros G0 G1. pose proof (both _ _ Checked) as [H End]. pose proof (both _ _ H) as [Contracts Positive].
    apply is_positive_correct in Positive.
    destruct (parts _ _ _ _ _ _ _ _ _ _ Contracts) as (Between & Sign & Shrinks).
    destruct (shapes _ _ _ _ _ _ _ _ _ _ Contracts) as (HA & HC & HL & HP).
    destruct (end_parts _ _ _ _ _ _ _ _ _ End) as (FA & FC & FN & FP & _).
    pose proof (fits_shape _ _ _ FN) as HN.
    pose proof (shrinks_form _ _ _ _ _ _ _ _ Shrinks e) as First. rewrite Q2R_zero in First.
    pose proof (end_form _ _ _ _ _ _ _ _ _ End e) as Last. rewrite Q2R_zero in Last.
    destruct (between_numbers _ _ _ _ _ Between) as (Lower & _ & _).
    assert (Semidefinite : forall v, 0 <= form n (real P) v).
    { intros v. apply Rle_trans with (Q2R lower * square n v); [apply Rmult_le_pos; [lra|apply square_nonnegative]|].
      apply (between_lower _ _ _ _ _ Between). }
    set (s := Q2R w * g) in *.
    set (f0 := apply n (error_matrix p A C L) e).
    set (f1 := (fun i => / Q2R w * apply n (end_matrix n p A C N (Q2R w)) e i) : vector).
    assert (0 <= s <= 1) by (split; [apply Rmult_le_pos; lra|exact G1]).
    assert (Begins : form n (real P) f0 <= Q2R factor * Q2R factor * form n (real P) e) by (unfold f0; lra).
    assert (Ends : form n (real P) f1 <= Q2R factor * Q2R factor * form n (real P) e).
    { unfold f1, form at 1. rewrite bilinear_scale_left, bilinear_scale_right.
      fold (form n (real P) (apply n (end_matrix n p A C N (Q2R w)) e)).
      apply Rmult_le_reg_l with (Q2R w * Q2R w); [apply Rmult_lt_0_compat; exact Positive|].
      set (X := form n (real P) (apply n (end_matrix n p A C N (Q2R w)) e)) in *.
      replace (Q2R w * Q2R w * (/ Q2R w * (/ Q2R w * X))) with X by (field; lra). lra. }
    apply Rle_trans with (form n (real P) (fun i => (1 - s) * f0 i + s * f1 i)).
    - apply Req_le, form_ext; [easy|]. intros i I. unfold f0, f1, s.
      rewrite <- (error_apply n p), <- (end_apply n p) by assumption.
      unfold plus_vector, minus_vector, scale_vector. field. lra.
    - apply Rle_trans with (1 := form_convex n (real P) s f0 f1 Semidefinite ltac:(assumption)).
      apply Rle_trans with ((1 - s) * (Q2R factor * Q2R factor * form n (real P) e)
        + s * (Q2R factor * Q2R factor * form n (real P) e)); [|lra].
      apply Rplus_le_compat; apply Rmult_le_compat_l; try lra; assumption.
  Qed.

  (** Every sequence with [e(k+1) = M(g(k)) e(k)], [0 <= g(k) <= 1/w]. *)
  Theorem sampled_error_contracts (e : nat -> vector) (g : nat -> R) :
    (forall k, 0 <= g k /\ Q2R w * g k <= 1) ->
    recursion n e (fun k => A * e k - L * (C * e k) + g k .* (A * (N * (C * e k)) + Q2R w .* (L * (C * e k))))%vector ->
    (forall k, quadratic n P (e (S k)) <= Q2R factor ^ 2 * quadratic n P (e k))
    /\ (forall k, quadratic n P (e k) <= Q2R factor ^ (2 * k) * quadratic n P (e 0%nat))
    /\ (forall k, norm n (e k) <= Q2R overshoot * Q2R factor ^ k * norm n (e 0%nat)).
  Proof.
    intros G E. pose proof (both _ _ Checked) as [H _]. pose proof (both _ _ H) as [Contracts _].
    destruct (parts _ _ _ _ _ _ _ _ _ _ Contracts) as (Between & Sign & _).
    destruct (shapes _ _ _ _ _ _ _ _ _ _ Contracts) as (_ & _ & _ & HP).
    apply (falls_at_each_step n P (Q2R factor) lower upper overshoot Between Sign). intros k.
    rewrite !quadratic_form by exact HP. destruct (G k) as [G0 G1].
    pose proof (mean_shrinks (g k) (e k) G0 G1) as K.
    rewrite (form_ext n (real P) (real P) (e (S k)) _ (fun i j _ _ => eq_refl) (fun i I => E k i I)).
    replace (Q2R factor ^ 2) with (Q2R factor * Q2R factor) by ring. exact K.
  Qed.

  (** [0 < r <= 1]: [1 - w g = r]. *)
  Lemma damping_between theta h z : 0 < h -> 0 < damping p theta (Q2R w) h z <= 1.
  Proof.
    intros Hh. pose proof (both _ _ Checked) as [H _]. pose proof (both _ _ H) as [_ Positive].
    apply is_positive_correct in Positive. unfold damping. set (q := Rmax (quadratic p theta z) 0).
    assert (0 <= q) by apply Rmax_r. assert (0 <= Q2R w * h * q) by (apply Rmult_le_pos; [apply Rmult_le_pos|]; lra).
    assert (1 <= sqrt (1 + 2 * Q2R w * h * q)).
    { apply Rle_trans with (sqrt 1); [rewrite sqrt_1; lra|]. apply sqrt_le_1; lra. }
    split; [apply Rinv_0_lt_compat; lra|]. apply Rle_trans with (/ 1); [|rewrite Rinv_1; lra]. apply
      Rinv_le_contravar; lra.
  Qed.

  (** The error of plant and observer, for every input. *)
  Theorem sampled_observer_contracts (B theta : list (list Q)) (h : R) (u x xhat : nat -> vector) :
    0 < h ->
    recursion n x (fun k => A * x k + B * u k)%vector ->
    recursion n xhat (fun k => let z := (C * x k - C * xhat k)%vector in
      let r := damping p theta (Q2R w) h z in let g := (1 - r) / Q2R w in
      (A * (xhat k - g .* (N * z)) + B * u k + r .* (L * z))%vector) ->
    let e k := (x k - xhat k)%vector in
    (forall k, quadratic n P (e (S k)) <= Q2R factor ^ 2 * quadratic n P (e k))
    /\ (forall k, quadratic n P (e k) <= Q2R factor ^ (2 * k) * quadratic n P (e 0%nat))
    /\ (forall k, norm n (e k) <= Q2R overshoot * Q2R factor ^ k * norm n (e 0%nat)).
  Proof.
    intros Hh Plant Observer e. pose proof (both _ _ Checked) as [H End]. pose proof (both _ _ H) as [Contracts
      Positive].
    apply is_positive_correct in Positive.
    destruct (shapes _ _ _ _ _ _ _ _ _ _ Contracts) as (HA & HC & HL & HP).
    destruct (end_parts _ _ _ _ _ _ _ _ _ End) as (_ & _ & FN & _ & _). pose proof (fits_shape _ _ _ FN) as HN.
    set (r := fun k => damping p theta (Q2R w) h (C * x k - C * xhat k)%vector).
    assert (D : forall k, 0 < r k <= 1) by (intros k; apply damping_between, Hh).
    apply (sampled_error_contracts e (fun k => (1 - r k) / Q2R w)).
    - intros k. specialize (D k). split.
      + apply Rmult_le_pos; [lra|apply Rlt_le, Rinv_0_lt_compat, Positive].
      + replace (Q2R w * ((1 - r k) / Q2R w)) with (1 - r k) by (field; lra). lra.
    - intros k i I. unfold e at 1. unfold minus_vector at 1. rewrite (Plant k i I), (Observer k i I). cbv zeta. fold
      (r k).
      set (z := (C * x k - C * xhat k)%vector).
      assert (Y : forall j, (j < p)%nat -> z j = (C * e k)%vector j).
      { intros j J. unfold z, e, minus_vector. rewrite !(times_vector_apply p n C) by assumption.
        symmetry. apply apply_minus_vector. }
      assert (HLz : (L * z)%vector i = (L * (C * e k))%vector i).
      { rewrite !(times_vector_apply n p L) by assumption. apply apply_ext; [reflexivity|exact Y]. }
      assert (HNz : forall j, (j < n)%nat -> (N * z)%vector j = (N * (C * e k))%vector j).
      { intros j J. rewrite !(times_vector_apply n p N) by assumption. apply apply_ext; [reflexivity|exact Y]. }
      assert (HAe : (A * e k)%vector i = (A * x k)%vector i - (A * xhat k)%vector i).
      { rewrite !(times_vector_apply n n A) by assumption. apply apply_minus_vector. }
      assert (HAz : (A * (xhat k - (1 - r k) / Q2R w .* (N * z)))%vector i
        = (A * xhat k)%vector i - (1 - r k) / Q2R w * (A * (N * (C * e k)))%vector i).
      { rewrite !(times_vector_apply n n A) by assumption.
        rewrite (apply_ext n (real A) (real A) _
          (fun j => xhat k j - (1 - r k) / Q2R w * (N * (C * e k))%vector j) i); [|reflexivity|].
        - rewrite (apply_minus_vector n (real A) (xhat k) (fun j => (1 - r k) / Q2R w * (N * (C * e k))%vector j)),
            apply_scale_vector. reflexivity.
        - intros j J. unfold minus_vector, scale_vector. rewrite HNz by exact J. reflexivity. }
      unfold plus_vector, minus_vector, scale_vector in *. rewrite HLz, HAz. rewrite HAe. field. lra.
  Qed.
End Error.
