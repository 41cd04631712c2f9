(** A step that contracts, and what a running observer adds to it: the bound of the theorem [deployed-observer] of
    certificates.

    One step takes e to at most [factor |e|_P], [|e|_P = sqrt(e'Pe)], and what rounding, noise and differences of the
    stored numbers add is at most [d_i + sum_j D_ij |e_j|] in each entry i, while [|e|_P <= start]. With [|e_j| <= s_j
    |e|_P], [t = D s], [d'|P|d <= beta^2] and [t'|P|t <= kappa^2], |P| entry by entry,
    [|e(k+1)|_P <= (factor + kappa) |e(k)|_P + beta]. With [factor + kappa < 1] the error stays within [start], and in
    the end within [limit = beta / (1 - factor - kappa)]. *)

From Coq Require Import Reals QArith Qreals ZArith List Lra Lia.
From Luenberger Require Import Vectors Definite Inequalities Decay LinearObserver DiscreteObserver Boxes Refuted
  SampledCubic.
Import ListNotations.
Local Open Scope R_scope.
Local Open Scope lazy_bool_scope.

(** ** The norm of P *)

(** [|v|_P = sqrt(v'Pv)] *)
Definition norm_in (n : nat) (P : matrix) (v : vector) : R := sqrt (form n P v).

Lemma norm_in_squared n P v : 0 <= form n P v -> norm_in n P v * norm_in n P v = form n P v.
Proof. apply sqrt_sqrt. Qed.

Lemma norm_in_nonnegative n P v : 0 <= norm_in n P v.
Proof. apply sqrt_pos. Qed.

Lemma form_plus n P a b :
  form n P (fun i => a i + b i) = form n P a + (bilinear n n P a b + bilinear n n P b a) + form n P b.
Proof. unfold form. rewrite bilinear_plus_left, !bilinear_plus_right. ring. Qed.

(** What is at most [t x^2 + y^2 / t] for every t > 0 is at most [2 x y]. *)
Lemma below_all_means z x y : 0 <= x -> 0 <= y ->
  (forall t, 0 < t -> z <= t * (x * x) + / t * (y * y)) -> z <= 2 * (x * y).
Proof.
  intros X Y H. destruct (Req_dec x 0) as [->|NX].
  - rewrite Rmult_0_l, Rmult_0_r. apply Rnot_lt_le. intros Z.
    assert (T : 0 < (y * y + 1) / z) by (apply Rdiv_lt_0_compat; [pose proof (Rle_0_sqr y); unfold Rsqr in *;
      lra|exact Z]).
    specialize (H _ T). assert (E : / ((y * y + 1) / z) * (y * y) = z * (y * y) / (y * y + 1)).
    { field. pose proof (Rle_0_sqr y). unfold Rsqr in *. split; lra. }
    rewrite E in H. assert (P : 0 < y * y + 1) by (pose proof (Rle_0_sqr y); unfold Rsqr in *; lra).
    assert (z * (y * y) / (y * y + 1) < z); [|lra].
    apply Rmult_lt_reg_r with (y * y + 1); [exact P|]. unfold Rdiv. rewrite Rmult_assoc, Rinv_l by lra. nra.
  - destruct (Req_dec y 0) as [->|NY].
    + rewrite Rmult_0_r, Rmult_0_r. apply Rnot_lt_le. intros Z. assert (P : 0 < x * x) by (apply Rmult_lt_0_compat;
      lra).
      assert (T : 0 < z / (2 * (x * x))) by (apply Rdiv_lt_0_compat; lra). specialize (H _ T).
      replace (z / (2 * (x * x)) * (x * x)) with (z / 2) in H by (field; exact NX). lra.
    + assert (T : 0 < y / x) by (apply Rdiv_lt_0_compat; lra). specialize (H _ T).
      replace (y / x * (x * x) + / (y / x) * (y * y)) with (2 * (x * y)) in H by (field; split; assumption). exact H.
Qed.

Lemma norm_in_triangle n P a b : (forall v, 0 <= form n P v) ->
  norm_in n P (fun i => a i + b i) <= norm_in n P a + norm_in n P b.
Proof.
  intros Positive. set (x := norm_in n P a). set (y := norm_in n P b).
  assert (X : 0 <= x) by apply norm_in_nonnegative. assert (Y : 0 <= y) by apply norm_in_nonnegative.
  assert (XX : x * x = form n P a) by (apply norm_in_squared, Positive).
  assert (YY : y * y = form n P b) by (apply norm_in_squared, Positive).
  assert (Cross : bilinear n n P a b + bilinear n n P b a <= 2 * (x * y)).
  { apply below_all_means; try assumption. intros t T. rewrite XX, YY.
    pose proof (Positive (fun i => t * a i + -1 * b i)) as F.
    rewrite (form_plus n P (fun i => t * a i) (fun i => -1 * b i)) in F. unfold form in F at 1 2.
    rewrite !bilinear_scale_left, !bilinear_scale_right in F. fold (form n P a) (form n P b) in F.
    apply Rmult_le_reg_l with t; [exact T|].
    replace (t * (t * form n P a + / t * form n P b)) with (t * t * form n P a + form n P b) by (field; lra). lra. }
  unfold norm_in at 1. rewrite <- (sqrt_square (x + y)) by lra. apply sqrt_le_1_alt.
  rewrite form_plus, <- XX, <- YY. replace ((x + y) * (x + y)) with (x * x + 2 * (x * y) + y * y) by ring. lra.
Qed.

(** Entries that are at most those of w. *)
Lemma norm_in_bound n P v w b : (forall i, (i < n)%nat -> Rabs (v i) <= w i) -> 0 <= b ->
  form n (magnitude P) w <= b * b -> norm_in n P v <= b.
Proof.
  intros H B L. unfold norm_in. rewrite <- (sqrt_square b) by exact B. apply sqrt_le_1_alt.
  apply Rle_trans with (2 := L). apply Rle_trans with (1 := Rle_abs _). unfold form, bilinear.
  apply Rle_trans with (1 := Rabs_sum _ _), sum_le. intros i I. rewrite Rabs_mult.
  apply Rmult_le_compat; try apply Rabs_pos; [apply H, I|].
  apply Rle_trans with (1 := Rabs_sum _ _), sum_le. intros j J. rewrite Rabs_mult.
  apply Rmult_le_compat; try apply Rabs_pos; [unfold magnitude; lra|apply H, J].
Qed.

(** ** What is added *)

(** [d_i + sum_j D_ij |e_j|] *)
Definition disturbance (n : nat) (d D : matrix) (e : vector) : vector :=
  fun i => d i 0%nat + apply n D (fun j => Rabs (e j)) i.

(** Cut to at most [w]. *)
Definition cut (w x : R) : R := Rmax (- w) (Rmin w x).

Lemma cut_bound w x : 0 <= w -> Rabs (cut w x) <= w.
Proof.
  intros H. unfold cut. apply Rabs_le. unfold Rmax, Rmin. destruct (Rle_dec w x);
    [destruct (Rle_dec (- w) w)|destruct (Rle_dec (- w) x)]; lra.
Qed.

Lemma cut_rest w x b : 0 <= w -> 0 <= b -> Rabs x <= w + b -> Rabs (x - cut w x) <= b.
Proof.
  intros W B H. pose proof (Rle_abs x). pose proof (Rle_abs (- x)). rewrite Rabs_Ropp in *. unfold cut. apply Rabs_le.
  unfold Rmax, Rmin. destruct (Rle_dec w x); [destruct (Rle_dec (- w) w)|destruct (Rle_dec (- w) x)]; lra.
Qed.

Section Step.
  Variables (n : nat) (P : matrix) (d D s : matrix) (beta kappa : R).
  Hypothesis Positive : forall v, 0 <= form n P v.
  Hypothesis Added : forall i, (i < n)%nat -> 0 <= d i 0%nat.
  Hypothesis Slope : forall i j, (i < n)%nat -> (j < n)%nat -> 0 <= D i j.
  Hypothesis Signs : forall j, (j < n)%nat -> 0 <= s j 0%nat.
  Hypothesis Widths : forall v i, (i < n)%nat -> Rabs (v i) <= s i 0%nat * norm_in n P v.
  Hypothesis Beta : 0 <= beta.
  Hypothesis Kappa : 0 <= kappa.
  Hypothesis Constant : form n (magnitude P) (fun i => d i 0%nat) <= beta * beta.
  Hypothesis Linear : form n (magnitude P) (fun i => apply n D (fun j => s j 0%nat) i) <= kappa * kappa.

  Lemma disturbed_step (e m next : vector) factor :
    norm_in n P m <= factor * norm_in n P e ->
    (forall i, (i < n)%nat -> Rabs (next i - m i) <= disturbance n d D e i) ->
    norm_in n P next <= (factor + kappa) * norm_in n P e + beta.
  Proof.
    intros Step Near. set (r := norm_in n P e) in *. assert (R0 : 0 <= r) by apply norm_in_nonnegative.
    set (first := fun i => cut (d i 0%nat) (next i - m i)).
    set (rest := fun i => next i - m i - first i).
    assert (First : norm_in n P first <= beta).
    { apply (norm_in_bound n P first (fun i => d i 0%nat)); try assumption. intros i I. apply cut_bound, Added, I. }
    assert (Rest : norm_in n P rest <= kappa * r).
    { apply (norm_in_bound n P rest (fun i => r * apply n D (fun j => s j 0%nat) i)).
      - intros i I. apply cut_rest; [apply Added, I| |].
        + apply Rmult_le_pos; [exact R0|]. apply sum_nonnegative. intros j J.
          apply Rmult_le_pos; [apply Slope; assumption|apply Signs, J].
        + apply Rle_trans with (1 := Near i I). unfold disturbance. apply Rplus_le_compat_l.
          unfold apply. rewrite <- sum_times. apply sum_le. intros j J.
          replace (r * (D i j * s j 0%nat)) with (D i j * (s j 0%nat * r)) by ring.
          apply Rmult_le_compat_l; [apply Slope; assumption|apply Widths, J].
      - apply Rmult_le_pos; assumption.
      - unfold form. rewrite bilinear_scale_left, bilinear_scale_right.
        replace (kappa * r * (kappa * r)) with (r * (r * (kappa * kappa))) by ring.
        apply Rmult_le_compat_l; [exact R0|]. apply Rmult_le_compat_l; [exact R0|exact Linear]. }
    assert (Split : norm_in n P next = norm_in n P (fun i => m i + (first i + rest i))).
    { unfold norm_in. f_equal. apply form_ext; [easy|]. intros i _. unfold rest. ring. }
    rewrite Split. apply Rle_trans with (1 := norm_in_triangle n P m (fun i => first i + rest i) Positive).
    pose proof (norm_in_triangle n P first rest Positive). lra.
  Qed.
End Step.

(** [x(k+1) <= f x(k) + beta] with [beta <= (1 - f) limit]. *)
Lemma geometric (x : nat -> R) f beta limit : 0 <= f -> beta <= (1 - f) * limit ->
  (forall k, x (S k) <= f * x k + beta) -> forall k, x k <= f ^ k * x 0%nat + limit -> x (S k) <= f ^ S k * x 0%nat +
    limit.
Proof.
  intros F B H k K. apply Rle_trans with (1 := H k). simpl.
  assert (f * x k <= f * (f ^ k * x 0%nat + limit)) by (apply Rmult_le_compat_l; assumption). lra.
Qed.

(** ** The checks *)

Lemma not_negative_number q : Qle_bool 0 q = true -> 0 <= Q2R q.
Proof. intros H. apply Qle_bool_iff, Qle_Rle in H. rewrite Q2R_zero in H. exact H. Qed.

(** 1 in row and column j. *)
Definition unit_numbers (n j : nat) : numbers :=
  (table n n (fun a b => if Nat.eqb a j then if Nat.eqb b j then 1 else 0 else 0)%Z, 1%positive).

Definition unit_matrix (j : nat) : matrix := fun a b => if Nat.eqb a j then if Nat.eqb b j then 1 else 0 else 0.

Lemma unit_numbers_correct n j : equals n n (unit_numbers n j) (unit_matrix j).
Proof.
  intros a b A B. unfold value, unit_numbers, unit_matrix. cbn [fst snd]. rewrite get_table by assumption.
  destruct (Nat.eqb a j), (Nat.eqb b j); lra.
Qed.

Lemma unit_form n j v : (j < n)%nat -> form n (unit_matrix j) v = v j * v j.
Proof.
  intros J. unfold form, bilinear, apply.
  rewrite (sum_ext n _ (fun i => identity j i * (v i * v j))).
  - rewrite (sum_delta n (fun i => v i * v j) j J). reflexivity.
  - intros i I. unfold unit_matrix, identity. rewrite (Nat.eqb_sym j i). destruct (Nat.eqb_spec i j) as [->|N].
    + rewrite Rmult_1_l. f_equal. rewrite (sum_ext n _ (fun l => identity j l * v l)).
      * apply sum_delta, J.
      * intros l _. unfold identity. rewrite (Nat.eqb_sym j l). reflexivity.
    + rewrite (sum_ext n _ (fun _ => 0)), sum_zero by (intros; ring). ring.
Qed.

(** [s_j^2 P - E_jj >= 0] for every j: [|v_j| <= s_j |v|_P]. *)
Definition are_widths (n : nat) (P s : list (list Q)) : bool :=
  all n (fun j => Qle_bool 0 (entry s j 0)
    &&& semidefinite n (subtracted n n (multiple n n (entry s j 0 * entry s j 0) (numbers_of n n P)) (unit_numbers n
      j))).

Lemma are_widths_correct n P s v j :
  fits n n P = true -> are_widths n P s = true -> (j < n)%nat -> (forall v, 0 <= form n (real P) v) ->
  0 <= real s j 0%nat /\ Rabs (v j) <= real s j 0%nat * norm_in n (real P) v.
Proof.
  intros Fit H J Positive. apply (all_correct _ _ j) in H; [|exact J]. apply both in H. destruct H as [Sign H].
  apply Qle_bool_iff, Qle_Rle in Sign. rewrite Q2R_zero in Sign. fold (real s j 0%nat) in Sign. split; [exact Sign|].
  pose proof (semidefinite_correct _ _ _ (subtracted_correct _ _ _ _ _ _ (multiple_correct n n _ _
    _ (fits_equals _ _ _ Fit)) (unit_numbers_correct n j)) H v) as K.
  unfold form in K. rewrite bilinear_minus, bilinear_scale in K. fold (form n (real P) v) (form n (unit_matrix j) v)
    in K.
  rewrite unit_form, Q2R_mult in K by exact J. fold (real s j 0%nat) in K.
  assert (N : 0 <= real s j 0%nat * norm_in n (real P) v) by (apply Rmult_le_pos;
    [exact Sign|apply norm_in_nonnegative]).
  rewrite <- (sqrt_square (real s j 0%nat * norm_in n (real P) v)) by exact N. rewrite <- sqrt_Rsqr_abs.
  apply sqrt_le_1_alt. unfold Rsqr.
  replace (real s j 0%nat * norm_in n (real P) v * (real s j 0%nat * norm_in n (real P) v))
    with (real s j 0%nat * real s j 0%nat * (norm_in n (real P) v * norm_in n (real P) v)) by ring.
  rewrite norm_in_squared by apply Positive. unfold real in *. lra.
Qed.

(** [x'|P|x <= b^2] for a column x. No definition: to see that both are the same the kernel would compute them. *)
Local Notation is_long n P x b :=
  (at_least 1 (negative 1 1 (times 1 n 1 (turned 1 n x) (times n n 1 (absolute n n (numbers_of n n P)) x)))
    (- (b * b))%Q).

Lemma column_form n M X (one : vector) :
  one 0%nat = 1 ->
  bilinear 1 1 (product n (transpose X) (product n M X)) one one = form n M (fun i => X i 0%nat).
Proof.
  intros One. rewrite bilinear_transpose_product, bilinear_product.
  assert (C : forall i, (i < n)%nat -> apply 1 X one i = X i 0%nat).
  { intros i _. unfold apply. cbn [sum]. rewrite One. ring. }
  apply bilinear_ext; [easy|exact C|exact C].
Qed.

Lemma is_long_correct n P x X b :
  fits n n P = true -> equals n 1 x X -> is_long n P x b = true ->
  form n (magnitude (real P)) (fun i => X i 0%nat) <= Q2R b * Q2R b.
Proof.
  intros Fit E H.
  pose proof (negative_correct _ _ _ _ (times_correct 1 n 1 _ _ _ _ (turned_correct 1 n _ _ E)
    (times_correct n n 1 _ _ _ _ (absolute_correct _ _ _ _ (fits_equals _ _ _ Fit)) E))) as Equal.
  set (one := (fun _ => 1) : vector). assert (One : one 0%nat = 1) by reflexivity. clearbody one.
  revert H. generalize dependent (negative 1 1 (times 1 n 1 (turned 1 n x)
    (times n n 1 (absolute n n (numbers_of n n P)) x))).
  intros Y Equal H. pose proof (at_least_correct 1 _ _ _ Equal H one) as K. unfold form in K.
  rewrite bilinear_scale, column_form, Q2R_opp, Q2R_mult in K by exact One.
  assert (Square : square 1 one = 1) by (unfold square; cbn [sum]; rewrite One; ring). rewrite Square in K. lra.
Qed.

(** No entry is negative. *)
Definition is_nonnegative (n m : nat) (M : list (list Q)) : bool :=
  all n (fun i => all m (fun j => Qle_bool 0 (entry M i j))).

Lemma is_nonnegative_correct n m M i j :
  is_nonnegative n m M = true -> (i < n)%nat -> (j < m)%nat -> 0 <= real M i j.
Proof.
  intros H I J. apply (all_correct _ _ i) in H; [|exact I]. apply (all_correct _ _ j) in H; [|exact J].
  apply Qle_bool_iff, Qle_Rle in H. rewrite Q2R_zero in H. exact H.
Qed.

(** What is added leaves a bound: [d] and [s] are columns, [D] has n rows and columns. *)
Definition disturbance_is_bounded (n : nat) (P d D s : list (list Q)) (lower factor kappa beta limit start : Q) : bool
  :=
  fits n n P &&& fits n 1 d &&& fits n n D &&& fits n 1 s
    &&& is_positive lower &&& is_at_least n P lower
    &&& is_nonnegative n 1 d &&& is_nonnegative n n D &&& are_widths n P s
    &&& Qle_bool 0 factor &&& Qle_bool 0 kappa &&& Qle_bool 0 beta &&& is_positive (1 - (factor + kappa))
    &&& is_long n P (numbers_of n 1 d) beta
    &&& is_long n P (times n n 1 (numbers_of n n D) (numbers_of n 1 s)) kappa
    &&& Qle_bool beta ((1 - (factor + kappa)) * limit) &&& Qle_bool limit start.

Section Bounded.
  Variables (n : nat) (P d D s : list (list Q)) (lower factor kappa beta limit start : Q).
  Hypothesis Checked : disturbance_is_bounded n P d D s lower factor kappa beta limit start = true.

  Let f := Q2R factor + Q2R kappa.

  (** Of every exact step m that contracts by the factor, and every one that differs from it by what is added: the error
      stays within [start], falls to [limit] at the rate of [factor + kappa], and is bounded entry by entry. *)
  Theorem bounded_errors (e m : nat -> vector) :
    (forall k, form n (real P) (m k) <= Q2R factor * Q2R factor * form n (real P) (e k)) ->
    (forall k, norm_in n (real P) (e k) <= Q2R start -> forall i, (i < n)%nat ->
      Rabs (e (S k) i - m k i) <= disturbance n (real d) (real D) (e k) i) ->
    norm_in n (real P) (e 0%nat) <= Q2R start ->
    (forall k, norm_in n (real P) (e k) <= Q2R start)
    /\ (forall k, norm_in n (real P) (e (S k)) <= f * norm_in n (real P) (e k) + Q2R beta)
    /\ (forall k, norm_in n (real P) (e k) <= f ^ k * norm_in n (real P) (e 0%nat) + Q2R limit)
    /\ (forall k i, (i < n)%nat ->
      Rabs (e k i) <= real s i 0%nat * (f ^ k * norm_in n (real P) (e 0%nat) + Q2R limit)).
  Proof.
    intros Contracts Near Begin. pose proof Checked as H. unfold disturbance_is_bounded in H.
    apply both in H. destruct H as [H LimitStart]. apply both in H. destruct H as [H BetaLimit].
    apply both in H. destruct H as [H Linear]. apply both in H. destruct H as [H Constant].
    apply both in H. destruct H as [H Below]. apply both in H. destruct H as [H Beta].
    apply both in H. destruct H as [H Kappa]. apply both in H. destruct H as [H Factor].
    apply both in H. destruct H as [H Widths]. apply both in H. destruct H as [H Slope].
    apply both in H. destruct H as [H Added]. apply both in H. destruct H as [H Least].
    apply both in H. destruct H as [H Lower]. apply both in H. destruct H as [H Fs].
    apply both in H. destruct H as [H FD]. apply both in H. destruct H as [FP Fd].
    destruct (positive_definite n P lower ltac:(unfold andb; rewrite Lower; exact Least)) as [Low Definite].
    assert (Positive : forall v, 0 <= form n (real P) v).
    { intros v. apply Rle_trans with (Q2R lower * square n v).
      - apply Rmult_le_pos; [lra|apply square_nonnegative].
      - rewrite <- (quadratic_form n P) by apply (fits_shape _ _ _ FP). apply Definite. }
    apply is_positive_correct in Below. rewrite Q2R_minus, Q2R_plus in Below.
    apply Qle_bool_iff, Qle_Rle in Factor, Kappa, Beta, BetaLimit, LimitStart.
    rewrite Q2R_zero in Factor, Kappa, Beta. rewrite Q2R_mult, Q2R_minus, Q2R_plus in BetaLimit.
    replace (Q2R 1) with 1 in * by (unfold Q2R; simpl; lra). fold f in Below, BetaLimit.
    assert (F0 : 0 <= f) by (unfold f; lra).
    assert (One : forall k, norm_in n (real P) (e k) <= Q2R start ->
      norm_in n (real P) (e (S k)) <= f * norm_in n (real P) (e k) + Q2R beta).
    { intros k Inside.
      apply (disturbed_step n (real P) (real d) (real D) (real s) (Q2R beta) (Q2R kappa)) with (m := m k);
        try assumption.
      - intros i I. apply (is_nonnegative_correct n 1 d i 0 Added I). lia.
      - intros i j I J. apply (is_nonnegative_correct n n D i j Slope I J).
      - intros j J. apply (are_widths_correct n P s (e k) j FP Widths J Positive).
      - intros v j J. apply (are_widths_correct n P s v j FP Widths J Positive).
      - apply (is_long_correct n P _ (real d) beta FP (fits_equals _ _ _ Fd) Constant).
      - apply (is_long_correct n P _ (product n (real D) (real s)) kappa FP
          (times_correct n n 1 _ _ _ _ (fits_equals _ _ _ FD) (fits_equals _ _ _ Fs)) Linear).
      - unfold norm_in at 1. rewrite <- (sqrt_square (Q2R factor * norm_in n (real P) (e k)))
          by (apply Rmult_le_pos; [exact Factor|apply norm_in_nonnegative]).
        apply sqrt_le_1_alt.
        replace (Q2R factor * norm_in n (real P) (e k) * (Q2R factor * norm_in n (real P) (e k)))
          with (Q2R factor * Q2R factor * (norm_in n (real P) (e k) * norm_in n (real P) (e k))) by ring.
        rewrite norm_in_squared by apply Positive. apply Contracts.
      - apply Near, Inside. }
    assert (Stays : forall k, norm_in n (real P) (e k) <= Q2R start).
    { induction k as [|k IH]; [exact Begin|]. apply Rle_trans with (1 := One k IH).
      assert (f * norm_in n (real P) (e k) <= f * Q2R start) by (apply Rmult_le_compat_l; assumption).
      assert ((1 - f) * Q2R limit <= (1 - f) * Q2R start) by (apply Rmult_le_compat_l; lra). lra. }
    assert (L0 : 0 <= Q2R limit).
    { apply Rmult_le_reg_l with (1 - f); lra. }
    assert (Falls : forall k, norm_in n (real P) (e k) <= f ^ k * norm_in n (real P) (e 0%nat) + Q2R limit).
    { induction k as [|k IH]; [simpl; lra|].
      apply (geometric (fun k => norm_in n (real P) (e k)) f (Q2R beta) (Q2R limit)); try assumption.
      intros l. apply One, Stays. }
    split; [exact Stays|]. split; [intros k; apply One, Stays|]. split; [exact Falls|]. intros k i I.
    destruct (are_widths_correct n P s (e k) i FP Widths I Positive) as [Sign W]. apply Rle_trans with (1 := W).
    apply Rmult_le_compat_l; [exact Sign|apply Falls].
  Qed.
End Bounded.

(** ** The statements *)

(** What is concluded of the error of a running observer. *)
Definition stays_and_falls (n : nat) (P s : list (list Q)) (rate limit start : Q) (e : nat -> vector) : Prop :=
  0 <= Q2R rate < 1
  /\ (forall k, sqrt (quadratic n P (e k)) <= Q2R start)
  /\ (forall k, sqrt (quadratic n P (e k)) <= Q2R rate ^ k * sqrt (quadratic n P (e 0%nat)) + Q2R limit)
  /\ (forall eps, 0 < eps -> exists K, forall k i, (K <= k)%nat -> (i < n)%nat ->
       Rabs (e k i) <= real s i 0%nat * (Q2R limit + eps)).

(** The step differs from m by at most what is added, while the error is within [start]. *)
Definition differs_by (n : nat) (P d D : list (list Q)) (start : Q) (e m : nat -> vector) : Prop :=
  forall k, sqrt (quadratic n P (e k)) <= Q2R start -> forall i, (i < n)%nat ->
  Rabs (e (S k) i - m k i) <= real d i 0%nat + sum n (fun j => real D i j * Rabs (e k j)).

(** [rate] for [factor + kappa]. *)
Definition running_is_bounded (n : nat) (P d D s : list (list Q)) (lower factor kappa rate beta limit start : Q) :
  bool :=
  disturbance_is_bounded n P d D s lower factor kappa beta limit start &&& Qeq_bool rate (factor + kappa).

Lemma running_stays n P d D s lower factor kappa rate beta limit start (e m : nat -> vector) :
  running_is_bounded n P d D s lower factor kappa rate beta limit start = true ->
  (forall k, form n (real P) (m k) <= Q2R factor * Q2R factor * form n (real P) (e k)) ->
  differs_by n P d D start e m -> sqrt (quadratic n P (e 0%nat)) <= Q2R start ->
  stays_and_falls n P s rate limit start e.
Proof.
  intros H Contracts Near Begin. apply both in H. destruct H as [H Rate].
  apply Qeq_bool_iff, Qeq_eqR in Rate. rewrite Q2R_plus in Rate.
  pose proof H as Parts. unfold disturbance_is_bounded in Parts.
  do 4 (apply both in Parts; destruct Parts as [Parts _]).
  apply both in Parts. destruct Parts as [Parts Below]. apply both in Parts. destruct Parts as [Parts _].
  apply both in Parts. destruct Parts as [Parts Kappa]. apply both in Parts. destruct Parts as [Parts Factor].
  do 3 (apply both in Parts; destruct Parts as [Parts _]).
  do 2 (apply both in Parts; destruct Parts as [Parts _]).
  do 2 (apply both in Parts; destruct Parts as [Parts _]).
  apply both in Parts. destruct Parts as [FP _]. pose proof (fits_shape _ _ _ FP) as HP.
  apply Qle_bool_iff, Qle_Rle in Kappa, Factor. rewrite Q2R_zero in Kappa, Factor.
  apply is_positive_correct in Below. rewrite Q2R_minus, Q2R_plus in Below.
  replace (Q2R 1) with 1 in Below by (unfold Q2R; simpl; lra).
  assert (Root : forall k, sqrt (quadratic n P (e k)) = norm_in n (real P) (e k)).
  { intros k. unfold norm_in. rewrite quadratic_form by exact HP. reflexivity. }
  destruct (bounded_errors n P d D s lower factor kappa beta limit start H e m Contracts) as (Stays & _ & Falls &
    Entries).
  { intros k Inside i I. apply (Near k); [rewrite Root; exact Inside|exact I]. }
  { rewrite <- Root. exact Begin. }
  rewrite <- Rate in *. repeat split; try lra.
  - intros k. rewrite Root. apply Stays.
  - intros k. rewrite !Root. apply Falls.
  - intros eps He. set (x := norm_in n (real P) (e 0%nat)) in *. assert (X : 0 <= x) by apply norm_in_nonnegative.
    destruct (pow_lt_1_zero (Q2R rate)) with (y := eps / (x + 1)) as (K & Small).
    + rewrite Rabs_pos_eq; lra.
    + apply Rdiv_lt_0_compat; lra.
    + exists K. intros k i Hk I. specialize (Small k Hk). assert (R0 : 0 <= Q2R rate ^ k) by (apply pow_le; lra).
      rewrite Rabs_pos_eq in Small by exact R0. apply Rle_trans with (1 := Entries k i I).
      apply Rmult_le_compat_l.
      * assert (W : are_widths n P s = true).
        { pose proof H as Parts'. unfold disturbance_is_bounded in Parts'.
          do 8 (apply both in Parts'; destruct Parts' as [Parts' _]). apply both in Parts'. apply Parts'. }
        apply (all_correct _ _ i) in W; [|exact I]. apply both in W. destruct W as [W _].
        apply not_negative_number, W.
      * assert (Q2R rate ^ k * x <= eps); [|lra].
        apply Rle_trans with (eps / (x + 1) * (x + 1)); [|apply Req_le; field; lra].
        apply Rmult_le_compat; lra.
Qed.

(** [F'P F - factor^2 P <= - q I] for a matrix F of numbers. *)
Definition map_numbers (n : nat) (F P : list (list Q)) (factor : Q) : numbers :=
  negative n n (stein_numbers n (numbers_of n n F) (numbers_of n n P) factor).

Definition map_shrinks (n : nat) (F P : list (list Q)) (factor q : Q) : bool :=
  fits n n F &&& fits n n P &&& at_least n (map_numbers n F P factor) q.

(** The form of [factor^2 P - F'P F]. *)
Lemma map_form n F P factor v :
  fits n n F = true -> fits n n P = true ->
  form n (scale (-1) (stein_matrix n (real F) (real P) (Q2R factor))) v
  = Q2R factor * Q2R factor * quadratic n P v - quadratic n P (F * v)%vector.
Proof.
  intros FF FP. unfold form at 1. rewrite bilinear_scale.
  fold (form n (stein_matrix n (real F) (real P) (Q2R factor)) v). rewrite stein_form.
  rewrite !quadratic_form by apply (fits_shape _ _ _ FP).
  rewrite (form_ext n (real P) (real P) (F * v)%vector (apply n (real F) v)); [ring|easy|].
  intros i I. apply (times_vector_apply n n); [apply (fits_shape _ _ _ FF)|exact I].
Qed.

Lemma map_shrinks_form n F P factor q v : map_shrinks n F P factor q = true ->
  quadratic n P (F * v)%vector - Q2R factor * Q2R factor * quadratic n P v <= - Q2R q * square n v.
Proof.
  intros H. apply both in H. destruct H as [H K]. apply both in H. destruct H as [FF FP].
  pose proof (at_least_correct _ _ _ _ (negative_correct _ _ _ _ (stein_numbers_correct _ _ _ factor _ _
    (fits_equals _ _ _ FF) (fits_equals _ _ _ FP))) K v) as G.
  rewrite map_form in G by assumption. lra.
Qed.

(** The fact of the stored F, with its margin q. *)
Theorem map_inequality n F P factor q :
  is_positive q &&& map_shrinks n F P factor q = true ->
  0 < Q2R q /\ forall v : vector, let w := (F * v)%vector in
  quadratic n P w - Q2R factor ^ 2 * quadratic n P v <= - Q2R q * square n v.
Proof.
  intros H. apply both in H. destruct H as [Positive H]. split; [apply is_positive_correct, Positive|].
  intros v w. pose proof (map_shrinks_form _ _ _ _ _ v H). unfold w. lra.
Qed.

(** It is false. *)
Theorem no_map_inequality n F P factor v :
  fits n n F &&& fits n n P &&& is_witness false n (map_numbers n F P factor) v = true ->
  exists v : vector, 0 < square n v /\
    let w := (F * v)%vector in 0 <= quadratic n P w - Q2R factor ^ 2 * quadratic n P v.
Proof.
  intros H. apply both in H. destruct H as [H K]. apply both in H. destruct H as [FF FP].
  destruct (is_witness_correct _ _ _ _ _ (negative_correct _ _ _ _ (stein_numbers_correct _ _ _ factor _ _
    (fits_equals _ _ _ FF) (fits_equals _ _ _ FP))) K) as (N & G & _).
  exists (column v). split; [exact N|]. intros w. rewrite map_form in G by assumption. unfold w. lra.
Qed.

Definition map_contracts (n : nat) (F P : list (list Q)) (factor lower upper overshoot : Q) : bool :=
  is_between n P lower upper overshoot &&& Qle_bool 0 factor &&& map_shrinks n F P factor 0.

(** The step of the stored F in exact arithmetic. *)
Theorem map_error_contracts n F P factor lower upper overshoot :
  map_contracts n F P factor lower upper overshoot = true -> forall e : nat -> vector,
  recursion n e (fun k => F * e k)%vector ->
  (forall k, quadratic n P (e (S k)) <= Q2R factor ^ 2 * quadratic n P (e k))
  /\ (forall k, quadratic n P (e k) <= Q2R factor ^ (2 * k) * quadratic n P (e 0%nat))
  /\ (forall k, norm n (e k) <= Q2R overshoot * Q2R factor ^ k * norm n (e 0%nat)).
Proof.
  intros H e E. apply both in H. destruct H as [H Shrinks]. apply both in H. destruct H as [Between Sign].
  apply (falls_at_each_step n P (Q2R factor) lower upper overshoot Between (not_negative_number _ Sign)). intros k.
  pose proof (map_shrinks_form _ _ _ _ _ (e k) Shrinks) as K. rewrite Q2R_zero in K.
  pose proof (both _ _ Shrinks) as [H' _]. pose proof (both _ _ H') as [_ FP].
  rewrite !(quadratic_form n P) in * by apply (fits_shape _ _ _ FP).
  rewrite (form_ext n (real P) (real P) (e (S k)) (F * e k)%vector (fun i j _ _ => eq_refl) (fun i I => E k i I)). lra.
Qed.

Section Running.
  Variables (n : nat) (P d D s : list (list Q)) (lower factor kappa rate beta limit start : Q).
  Hypothesis Bounded : running_is_bounded n P d D s lower factor kappa rate beta limit start = true.

  (** The step [xhat+ = F xhat + B u + L y]. *)
  Theorem running_joined (F : list (list Q)) :
    map_shrinks n F P factor 0 = true -> forall e : nat -> vector,
    differs_by n P d D start e (fun k => F * e k)%vector -> sqrt (quadratic n P (e 0%nat)) <= Q2R start ->
    stays_and_falls n P s rate limit start e.
  Proof.
    intros Shrinks e Near Begin.
    refine (running_stays n P d D s lower factor kappa rate beta limit start e _ Bounded _ Near Begin).
    intros k. pose proof (map_shrinks_form _ _ _ _ _ (e k) Shrinks) as K. rewrite Q2R_zero in K.
    pose proof (both _ _ Shrinks) as [H _]. pose proof (both _ _ H) as [_ FP].
    rewrite !(quadratic_form n P) in K by apply (fits_shape _ _ _ FP). lra.
  Qed.

  (** The step [xhat+ = A xhat + B u + L (y - C xhat)]. *)
  Theorem running_linear (p : nat) (A C L : list (list Q)) :
    shrinks n p A C L P factor 0 = true -> forall e : nat -> vector,
    differs_by n P d D start e (fun k => A * e k - L * (C * e k))%vector -> sqrt (quadratic n P (e 0%nat)) <= Q2R
      start ->
    stays_and_falls n P s rate limit start e.
  Proof.
    intros Shrinks e Near Begin.
    refine (running_stays n P d D s lower factor kappa rate beta limit start e _ Bounded _ Near Begin).
    intros k. pose proof (shrinks_form _ _ _ _ _ _ _ _ Shrinks (e k)) as K. rewrite Q2R_zero in K.
    pose proof (both _ _ Shrinks) as [Fit _]. destruct (linear_fits_parts _ _ _ _ _ _ Fit) as (FA & FC & FL & _).
    rewrite (form_ext n (real P) (real P) _ (apply n (error_matrix p A C L) (e k))); [lra|easy|].
    intros i I. apply (error_apply n p); try exact I; eapply fits_shape; eassumption.
  Qed.

  (** The step of the sampled cubic observer, with any g from 0 to 1/w at each step. *)
  Theorem running_cubic (p : nat) (A C L N : list (list Q)) (w lower' upper overshoot : Q) :
    sampled_contracts n p A C L N P w factor lower' upper overshoot = true -> forall (e : nat -> vector) (g : nat -> R),
    (forall k, 0 <= g k /\ Q2R w * g k <= 1) ->
    differs_by n P d D start e
      (fun k => A * e k - L * (C * e k) + g k .* (A * (N * (C * e k)) + Q2R w .* (L * (C * e k))))%vector ->
    sqrt (quadratic n P (e 0%nat)) <= Q2R start -> stays_and_falls n P s rate limit start e.
  Proof.
    intros Shrinks e g G Near Begin.
    refine (running_stays n P d D s lower factor kappa rate beta limit start e _ Bounded _ Near Begin).
    intros k. destruct (G k) as [G0 G1]. apply (mean_shrinks _ _ _ _ _ _ _ _ _ _ _ _ Shrinks (g k) (e k) G0 G1).
  Qed.
End Running.
