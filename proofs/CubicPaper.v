(** What the cubic paper states and is false, as theorems: a witness for each.

    [cubic.thm2.strict], [cubic.thm5.equality] and [cubic.ex3.sign-of-n] are the names of the claims in the ledger,
      which
    writes the numbers of its examples into a file of its own. *)

From Coq Require Import Reals QArith Qreals ZArith List Lra Lia.
From Luenberger Require Import Vectors Definite Inequalities Decay LinearObserver CubicObserver Blocks Refuted
  Nullspace.
Import ListNotations.
Local Open Scope R_scope.
Local Open Scope lazy_bool_scope.

(** [v'(P N C + C'N'P)v], the form of (13), for matrices of real numbers. *)
Definition form_13 (n p : nat) (P N C : matrix) (v : vector) : R :=
  let d := apply p N (apply n C v) in inner n v (apply n P d) + inner n d (apply n P v).

(** ** (13) is never strict *)

(** With fewer outputs than states there is a v, not 0, at which the form of (13) is 0, whatever P and N are: no N
    fulfils [P N C + C'N'P < 0]. *)
Theorem inequality_13_is_never_strict n p (P N C : matrix) :
  (p < n)%nat -> exists v : vector, 0 < square n v /\ form_13 n p P N C v = 0.
Proof.
  intros L. destruct (nullspace p n C L) as (v & Positive & Zero). exists v. split; [exact Positive|].
  assert (D : forall i, apply p N (apply n C v) i = 0).
  { intros i. unfold apply at 1. rewrite (sum_ext p _ (fun _ => 0)); [apply sum_zero|]. intros j J.
    rewrite Zero by exact J. ring. }
  unfold form_13, inner. rewrite <- sum_plus, (sum_ext n _ (fun _ => 0)); [apply sum_zero|]. intros i _. rewrite D.
  unfold apply at 1. rewrite (sum_ext n _ (fun _ => 0)), sum_zero; [ring|]. intros j _. rewrite D. ring.
Qed.

(** ** N with the wrong sign *)

(** [C N > 0], one output. *)
Definition has_wrong_sign (n : nat) (C N : list (list Q)) : bool :=
  fits 1 n C &&& fits n 1 N &&& (0 <? get (fst (times 1 n 1 (numbers_of 1 n C) (numbers_of n 1 N))) 0 0)%Z.

Lemma wrong_sign n C N : has_wrong_sign n C N = true ->
  fits 1 n C = true /\ fits n 1 N = true /\ 0 < product n (real C) (real N) 0%nat 0%nat.
Proof.
  intros H. apply both in H. destruct H as [H Sign]. apply both in H. destruct H as [FC FN]. repeat split;
    try assumption.
  rewrite <- (times_correct 1 n 1 _ _ _ _ (fits_equals _ _ _ FC) (fits_equals _ _ _ FN) 0 0)%nat by lia.
  apply Z.ltb_lt, IZR_lt in Sign. unfold value, Rdiv. apply Rmult_lt_0_compat; [exact Sign|].
  apply Rinv_0_lt_compat, denominator_positive.
Qed.

(** If [C N > 0], the form of (13) is positive at v = N, for every positive definite P: no P fulfils (13'). *)
Theorem no_matrix_for_13 n C N :
  has_wrong_sign n C N = true ->
  forall P : matrix, (forall v : vector, 0 < square n v -> 0 < form n P v) ->
  exists v : vector, 0 < form_13 n 1 P (real N) (real C) v.
Proof.
  intros H P Positive. destruct (wrong_sign _ _ _ H) as (FC & FN & Sign).
  set (v := (fun i => real N i 0%nat) : vector). set (cn := product n (real C) (real N) 0%nat 0%nat) in *.
  assert (V : 0 < square n v).
  { apply Rnot_le_lt. intros Z. pose proof (square_nonnegative n v).
    assert (E : square n v = 0) by lra. apply (Rlt_irrefl 0). apply Rlt_le_trans with (1 := Sign). apply Req_le.
    unfold cn, product. rewrite (sum_ext n _ (fun _ => 0)); [apply sum_zero|]. intros l L.
    assert (K : v l = 0).
    { destruct (Req_dec (v l) 0) as [K|K]; [exact K|]. pose proof (square_positive n v l L K). lra. }
    unfold v in K. rewrite K. ring. }
  exists v. specialize (Positive v V). unfold form_13.
  assert (D : forall i, apply 1 (real N) (apply n (real C) v) i = cn * v i).
  { intros i. unfold apply at 1. simpl. fold (v i). unfold apply, v, cn, product. ring. }
  set (d := apply 1 (real N) (apply n (real C) v)) in *.
  assert (A : inner n v (apply n P d) = cn * form n P v).
  { unfold form, bilinear, inner. rewrite <- sum_times. apply sum_ext. intros i _.
    rewrite (apply_ext n P P d (fun j => cn * v j)) by (try reflexivity; intros; apply D).
    rewrite apply_scale_vector. ring. }
  assert (B : inner n d (apply n P v) = cn * form n P v).
  { unfold form, bilinear, inner. rewrite <- sum_times. apply sum_ext. intros i _. rewrite D. ring. }
  rewrite A, B. assert (0 < cn * form n P v) by (apply Rmult_lt_0_compat; assumption). lra.
Qed.

(** ** Errors that stand still *)

Lemma constant_solution T n (c f : vector) :
  (forall i, (i < n)%nat -> f i = 0) -> solution T n (fun _ => c) (fun _ => f).
Proof.
  intros H i I. split; [apply right_continuous_const|]. intros t _. rewrite H by exact I. apply derivable_pt_lim_const.
Qed.

(** [(A - L C)w = N] and [theta (C w) < 0], one output. *)
Definition is_direction (n : nat) (A C L N theta w : list (list Q)) : bool :=
  linear_fits n 1 A C L A &&& fits n 1 N &&& fits 1 1 theta &&& fits n 1 w
    &&& (let zero := subtracted n 1 (times n n 1 (error_numbers n 1 A C L) (numbers_of n 1 w)) (numbers_of n 1 N) in
         all n (fun i => get (fst zero) i 0 =? 0)%Z)
    &&& (get (fst (times 1 1 1 (numbers_of 1 1 theta) (times 1 n 1 (numbers_of 1 n C) (numbers_of n 1 w)))) 0 0 <? 0)%Z.

(** There is an error, not 0, that stands still: [v = - theta y^3 w] with [y = C v]. (11) is violated. *)
Theorem error_stands_still n A C L N theta w :
  is_direction n A C L N theta w = true ->
  exists v : vector, 0 < square n v /\ forall T,
  solution T n (fun _ => v) (fun _ => let y := (C * v)%vector in
    (A * v - L * y + quadratic 1 theta y .* (N * y))%vector).
Proof.
  intros H. apply both in H. destruct H as [H Negative]. apply both in H. destruct H as [H Zero].
  apply both in H. destruct H as [H Fw]. apply both in H. destruct H as [H Ft]. apply both in H. destruct H as [Fit FN].
  destruct (linear_fits_parts _ _ _ _ _ _ Fit) as (FA & FC & FL & _).
  pose proof (fits_shape _ _ _ FA) as HA. pose proof (fits_shape _ _ _ FC) as HC. pose proof (fits_shape _ _ _ FL) as
    HL.
  pose proof (fits_shape _ _ _ FN) as HN. pose proof (fits_shape _ _ _ Ft) as Ht.
  set (u := (fun i => real w i 0%nat) : vector). set (F := error_matrix 1 A C L).
  set (cw := sum n (fun j => real C 0%nat j * u j)). set (th := real theta 0%nat 0%nat).
  assert (Solves : forall i, (i < n)%nat -> apply n F u i = real N i 0%nat).
  { intros i I. cbv zeta in Zero. apply (all_correct _ _ i) in Zero; [|exact I]. apply Z.eqb_eq in Zero.
    pose proof (subtracted_correct n 1 _ _ _ _ (times_correct n n 1 _ _ _ _ (error_numbers_correct _ _ _ _ _ FA FC FL)
      (fits_equals _ _ _ Fw)) (fits_equals _ _ _ FN) i 0%nat I Nat.lt_0_1) as K.
    unfold value in K. rewrite Zero in K. unfold minus, Rdiv in K. rewrite Rmult_0_l in K. unfold product in K.
    unfold apply, F, u. lra. }
  assert (Sign : th * cw < 0).
  { pose proof (times_correct 1 1 1 _ _ _ _ (fits_equals _ _ _ Ft) (times_correct 1 n 1 _ _ _ _ (fits_equals _ _ _ FC)
      (fits_equals _ _ _ Fw)) 0%nat 0%nat Nat.lt_0_1 Nat.lt_0_1) as K.
    unfold product at 1 in K. simpl in K. unfold product in K. fold th u in K.
    change (sum n (fun l => real C 0%nat l * real w l 0%nat)) with cw in K.
    apply Z.ltb_lt, IZR_lt in Negative. unfold value, Rdiv in K.
    assert (D : 0 < / IZR (Zpos (snd (times 1 1 1 (numbers_of 1 1 theta) (times 1 n 1 (numbers_of 1 n C)
      (numbers_of n 1 w)))))) by apply Rinv_0_lt_compat, denominator_positive.
    assert (th * cw = 0 + th * cw) by ring. rewrite H, <- K.
    apply Ropp_lt_cancel. rewrite Ropp_0, Ropp_mult_distr_l. apply Rmult_lt_0_compat; lra. }
  set (kappa := - (th * cw)). assert (Kappa : 0 < kappa) by (unfold kappa; lra).
  set (y := / sqrt kappa).
  assert (Root : 0 < sqrt kappa) by apply sqrt_lt_R0, Kappa.
  assert (Square : y * y * kappa = 1).
  { unfold y. rewrite <- (sqrt_sqrt kappa) at 3 by lra. field. lra. }
  assert (Y : 0 < y) by apply Rinv_0_lt_compat, Root.
  set (v := (fun i => - (th * y * y * y) * u i) : vector).
  assert (Output : (C * v)%vector 0%nat = y).
  { rewrite (times_vector_apply 1 n) by (assumption || lia). unfold v. rewrite apply_scale_vector.
    change (apply n (real C) u 0%nat) with cw.
    replace (- (th * y * y * y) * cw) with (y * (y * y * kappa)) by (unfold kappa; ring). rewrite Square. ring. }
  exists v. split.
  - apply Rnot_le_lt. intros Z. pose proof (square_nonnegative n v).
    assert (E : square n v = 0) by lra. apply (Rlt_irrefl 0). apply Rlt_le_trans with (1 := Y). apply Req_le.
    rewrite <- Output, (times_vector_apply 1 n) by (assumption || lia). unfold apply.
    rewrite (sum_ext n _ (fun _ => 0)); [apply sum_zero|]. intros j J.
    destruct (Req_dec (v j) 0) as [K|K]; [rewrite K; ring|]. pose proof (square_positive n v j J K). lra.
  - intros T. cbv zeta. apply constant_solution. intros i I. unfold plus_vector, scale_vector.
    rewrite (error_apply n 1) by assumption. fold F. unfold v at 1. rewrite apply_scale_vector, Solves by exact I.
    rewrite (times_vector_apply n 1 N) by assumption. rewrite (quadratic_form 1) by exact Ht.
    unfold form, bilinear, apply. simpl. rewrite Output. fold th. ring.
Qed.

(** ** Theorem 5 with equality in (23) *)

Definition is_zero (n m : nat) (X : numbers) : bool := all n (fun i => all m (fun j => get (fst X) i j =? 0)%Z).

Lemma is_zero_correct n m X M : equals n m X M -> is_zero n m X = true -> same n m M nothing.
Proof.
  intros E H i j I J. rewrite <- (E i j I J). apply (all_correct _ _ i) in H; [|exact I].
  apply (all_correct _ _ j) in H; [|exact J]. apply Z.eqb_eq in H. unfold value, Rdiv. rewrite H. unfold nothing. ring.
Qed.

(** [F e + eps e + (y'theta y) N y], [y = C e], at a column of numbers. *)
Definition flow_numbers (n p : nat) (A C L N theta : list (list Q)) (eps : Q) (e : list (list Q)) : numbers :=
  let e := numbers_of n 1 e in
  let y := times p n 1 (numbers_of p n C) e in
  added n 1 (added n 1 (times n n 1 (error_numbers n p A C L) e) (multiple n 1 eps e))
    (times n 1 1 (times n p 1 (numbers_of n p N) y) (form_at p (numbers_of p p theta) y)).

(** Every hypothesis of Theorem 5 with equality in (23), [2 eps largest = least], and an error that stands still. *)
Definition stands_at_equality (n p : nat) (A C L N P Q0 theta : list (list Q)) (eps positive least largest margin : Q)
  (e : list (list Q)) : bool :=
  linear_fits n p A C L P &&& fits n n Q0 &&& fits n p N &&& fits p p theta &&& fits n 1 e
    &&& is_positive positive &&& at_least n (numbers_of n n P) positive
    &&& is_positive least &&& at_least n (numbers_of n n Q0) least
    &&& at_least n (negative n n (numbers_of n n P)) (- largest)
    &&& Qeq_bool (2 * eps * largest) least
    &&& is_zero n n (added n n (lyapunov_numbers n (error_numbers n p A C L) (numbers_of n n P) 0) (numbers_of n n Q0))
    &&& is_positive margin
    &&& is_dissipative n p C P N margin
    &&& semidefinite p (numbers_of p p theta)
    &&& (sign_at n (multiple_of_identity n 1) (numbers_of n 1 e) =? 1)%Z
    &&& is_zero n 1 (flow_numbers n p A C L N theta eps e).

Theorem equality_does_not_suffice n p A C L N P Q0 theta eps positive least largest margin e0 :
  stands_at_equality n p A C L N P Q0 theta eps positive least largest margin e0 = true ->
  (* P > 0 and Q > 0 *)
  (0 < Q2R positive /\ forall v, Q2R positive * square n v <= quadratic n P v)
  /\ (0 < Q2R least /\ forall v, Q2R least * square n v <= quadratic n Q0 v)
  (* (9), hence (12) *)
  /\ (forall v : vector, let w := (A * v - L * (C * v))%vector in
       inner n w (P * v)%vector + inner n v (P * w)%vector = - quadratic n Q0 v)
  (* (13), strictly *)
  /\ (0 < Q2R margin /\ forall v : vector, let d := (N * (C * v))%vector in
       inner n v (P * d)%vector + inner n d (P * v)%vector <= - Q2R margin * square n v)
  (* theta >= 0 *)
  /\ (forall y, 0 <= quadratic p theta y)
  (* (23) with equality: eps = least / (2 largest), the eigenvalues of P at most largest *)
  /\ (2 * Q2R eps * Q2R largest = Q2R least /\ forall v, quadratic n P v <= Q2R largest * square n v)
  (* and an error, not 0, that stands still *)
  /\ exists e : vector, 0 < square n e /\ forall T,
     solution T n (fun _ => e) (fun _ => let y := (C * e)%vector in
       (A * e + Q2R eps .* e - L * y + quadratic p theta y .* (N * y))%vector).
Proof.
  intros H. unfold stands_at_equality in H. do 16 (let K := fresh "Check" in apply both in H; destruct H as [H K]).
    rename Check into Standing.
  rename Check0 into Nonzero. rename Check1 into Theta. rename Check2 into Below13. rename Check3 into Margin.
  rename Check4 into Equation. rename Check5 into Equal. rename Check6 into Largest. rename Check7 into Least.
  rename Check8 into LeastPositive. rename Check9 into Positive. rename Check10 into IsPositive. rename Check11 into Fe.
  rename Check12 into Ft. rename Check13 into FN. rename Check14 into FQ.
  destruct (linear_fits_parts _ _ _ _ _ _ H) as (FA & FC & FL & FP).
  pose proof (fits_shape _ _ _ FA) as HA. pose proof (fits_shape _ _ _ FC) as HC. pose proof (fits_shape _ _ _ FL) as
    HL.
  pose proof (fits_shape _ _ _ FN) as HN. pose proof (fits_shape _ _ _ Ft) as Ht. pose proof (fits_shape _ _ _ FP) as
    HP.
  pose proof (fits_shape _ _ _ FQ) as HQ.
  repeat split.
  - apply is_positive_correct, IsPositive.
  - intros v. rewrite quadratic_form by exact HP. apply (at_least_correct _ _ _ _ (fits_equals _ _ _ FP) Positive).
  - apply is_positive_correct, LeastPositive.
  - intros v. rewrite quadratic_form by exact HQ. apply (at_least_correct _ _ _ _ (fits_equals _ _ _ FQ) Least).
  - intros v w. pose proof (lyapunov_quadratic n p A C L P 0 v H) as K. cbv zeta in K. fold w in K.
    pose proof (is_zero_correct _ _ _ _ (added_correct _ _ _ _ _ _ (lyapunov_numbers_correct _ _ _ 0 _ _
      (error_numbers_correct _ _ _ _ _ FA FC FL) (fits_equals _ _ _ FP)) (fits_equals _ _ _ FQ)) Equation) as Z.
    assert (F : form n (plus (lyapunov_matrix n (error_matrix p A C L) (real P) (Q2R 0)) (real Q0)) v = 0).
    { rewrite (form_ext n _ nothing v v Z) by easy. apply bilinear_nothing. }
    unfold form in F. rewrite bilinear_plus, Q2R_zero in F. rewrite quadratic_form by exact HQ. unfold form in *. lra.
  - apply is_positive_correct, Margin.
  - apply (dissipation n p C P N margin Below13).
  - intros y. rewrite quadratic_form by exact Ht. apply (semidefinite_correct _ _ _ (fits_equals _ _ _ Ft) Theta).
  - apply Qeq_bool_iff, Qeq_eqR in Equal. rewrite !Q2R_mult in Equal. rewrite <- Equal. unfold Q2R at 3. simpl. lra.
  - intros v. rewrite quadratic_form by exact HP.
    pose proof (at_least_correct _ _ _ _ (negative_correct _ _ _ _ (fits_equals _ _ _ FP)) Largest v) as K.
    unfold form in K. rewrite bilinear_scale, Q2R_opp in K. unfold form. lra.
  - exists (column e0). split.
    + apply Z.eqb_eq in Nonzero.
      destruct (sign_at_correct n _ _ _ e0 (multiple_of_identity_correct n 1) (fits_equals _ _ _ Fe)) as (Gt & _ & _).
      specialize (Gt Nonzero). unfold form in Gt. rewrite bilinear_scale in Gt.
      fold (form n identity (column e0)) in Gt. rewrite form_identity in Gt.
      replace (Q2R 1) with 1 in Gt by (unfold Q2R; simpl; lra). lra.
    + intros T. cbv zeta. apply constant_solution. intros i I.
      pose proof (times_correct p n 1 _ _ _ _ (fits_equals _ _ _ FC) (fits_equals _ _ _ Fe)) as EY.
      pose proof (is_zero_correct _ _ _ _ (added_correct _ _ _ _ _ _ (added_correct _ _ _ _ _ _
        (times_correct n n 1 _ _ _ _ (error_numbers_correct _ _ _ _ _ FA FC FL) (fits_equals _ _ _ Fe))
        (multiple_correct _ _ eps _ _ (fits_equals _ _ _ Fe)))
        (times_correct n 1 1 _ _ _ _ (times_correct n p 1 _ _ _ _ (fits_equals _ _ _ FN) EY)
          (times_correct 1 p 1 _ _ _ _ (turned_correct 1 p _ _ EY) (times_correct p p 1 _ _ _ _ (fits_equals _ _ _ Ft)
            EY))))
        Standing i 0%nat I Nat.lt_0_1) as K.
      unfold nothing, plus, scale in K. rewrite <- K. unfold plus_vector, minus_vector, scale_vector.
      assert (Y : forall j, (j < p)%nat -> (C * column e0)%vector j = product n (real C) (real e0) j 0%nat).
      { intros j J. rewrite (times_vector_apply p n C) by assumption. reflexivity. }
      pose proof (error_apply n p A C L (column e0) i HA HC HL I) as Flow. unfold minus_vector in Flow.
      rewrite (times_vector_apply n p N) by assumption. rewrite (quadratic_form p) by exact Ht.
      rewrite (form_ext p (real theta) (real theta) _ (fun j => product n (real C) (real e0) j 0%nat)
        (fun i j _ _ => eq_refl) Y).
      rewrite (apply_ext p (real N) (real N) _ (fun j => product n (real C) (real e0) j 0%nat) i (fun j _ => eq_refl)
        Y).
      change (product n (error_matrix p A C L) (real e0) i 0%nat) with (apply n (error_matrix p A C L) (column e0) i).
      rewrite <- Flow. change (real e0 i 0%nat) with (column e0 i).
      set (y := (fun j => product n (real C) (real e0) j 0%nat) : vector).
      replace (product 1 (product p (real N) (product n (real C) (real e0)))
        (product p (transpose (product n (real C) (real e0))) (product p (real theta) (product n (real C) (real e0)))) i
        0%nat) with (apply p (real N) y i * form p (real theta) y).
      * ring.
      * unfold product at 1. simpl sum. change (product p (real N) (product n (real C) (real e0)) i 0%nat)
          with (apply p (real N) y i). unfold product at 1.
        change (sum p (fun l => transpose (product n (real C) (real e0)) 0%nat l
          * product p (real theta) (product n (real C) (real e0)) l 0%nat)) with (form p (real theta) y). ring.
Qed.
