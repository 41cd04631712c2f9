(** A checker of positive semidefiniteness for matrices of rational numbers, proved correct.

    Numbers are integers over one denominator for a whole matrix, so that sums and products need no greatest common
    divisors. [semidefinite n M = true] implies [v'Mv >= 0] for every real v ([semidefinite_correct]). It is decided by

    - a Cholesky factor G of [W M W], W diagonal, that is computed in integers of about 100 bits: nothing is assumed of
      it, but [W M W - G G'] is formed exactly and has to be diagonally dominant;
    - if that fails, fraction-free elimination (Bareiss), of which each division is checked to be exact. It decides
      singular matrices, too. *)

From Coq Require Import Reals QArith Qreals ZArith List Lra Lia Bool.
From Luenberger Require Import Vectors.
Import ListNotations.
Local Open Scope R_scope.
Local Open Scope lazy_bool_scope.

(** ** Matrices of integers *)

Definition get (M : list (list Z)) (i j : nat) : Z := nth j (nth i M []) 0%Z.

Definition table (n m : nat) (f : nat -> nat -> Z) : list (list Z) :=
  map (fun i => map (f i) (seq 0 m)) (seq 0 n).

Lemma nth_map_seq {X} (f : nat -> X) (d : X) n i : (i < n)%nat -> nth i (map f (seq 0 n)) d = f i.
Proof.
  intros L. rewrite nth_indep with (d' := f 0%nat) by (rewrite map_length, seq_length; exact L).
  rewrite map_nth, seq_nth by exact L. reflexivity.
Qed.

Lemma get_table n m f i j : (i < n)%nat -> (j < m)%nat -> get (table n m f) i j = f i j.
Proof. intros L K. unfold get, table. rewrite !nth_map_seq by assumption. reflexivity. Qed.

Definition all (n : nat) (f : nat -> bool) : bool := forallb f (seq 0 n).

(* [&&&] and [|||] of Coq.Bool do not compute what they do not need, as [&&] and [||] do in [vm_compute]. *)
Lemma both (a b : bool) : a &&& b = true -> a = true /\ b = true.
Proof. destruct a; [split; [reflexivity|assumption]|discriminate]. Qed.

Lemma one_of (a b : bool) : a ||| b = true -> a = true \/ b = true.
Proof. destruct a; [left; reflexivity|right; assumption]. Qed.

Lemma all_correct n f i : all n f = true -> (i < n)%nat -> f i = true.
Proof. intros H L. unfold all in H. rewrite forallb_forall in H. apply H, in_seq. lia. Qed.

Fixpoint zsum (n : nat) (f : nat -> Z) : Z :=
  match n with O => 0 | S k => zsum k f + f k end%Z.

Lemma IZR_zsum n f : IZR (zsum n f) = sum n (fun i => IZR (f i)).
Proof. induction n as [|n IH]; simpl; [reflexivity|]. rewrite plus_IZR, IH. reflexivity. Qed.

Definition over_reals (M : list (list Z)) : matrix := fun i j => IZR (get M i j).

(** ** Diagonally dominant matrices *)

Definition dominant (n : nat) (E : list (list Z)) : bool :=
  all n (fun i => zsum n (fun j => Z.abs (get E i j) + Z.abs (get E j i)) <=? 4 * get E i i)%Z.

Lemma below_product e x y : - Rabs e * (x * x + y * y) / 2 <= e * (x * y).
Proof.
  assert (0 <= (x + y) * (x + y)) by apply Rle_0_sqr.
  assert (0 <= (x - y) * (x - y)) by apply Rle_0_sqr.
  unfold Rabs. destruct (Rcase_abs e); nra.
Qed.

Lemma dominant_correct n E v : dominant n E = true -> 0 <= form n (over_reals E) v.
Proof.
  intros H.
  assert (D : forall i, (i < n)%nat ->
    sum n (fun j => Rabs (IZR (get E i j)) + Rabs (IZR (get E j i))) <= 4 * IZR (get E i i)).
  { intros i L. apply (all_correct _ _ i) in H; [|exact L]. apply Z.leb_le in H.
    apply IZR_le in H. rewrite IZR_zsum, mult_IZR in H.
    eapply Rle_trans; [|exact H]. apply Req_le, sum_ext. intros j _. rewrite plus_IZR, !abs_IZR. reflexivity. }
  set (e := fun i j => IZR (get E i j)) in *.
  apply Rle_trans with
    (sum n (fun i => sum n (fun j => 2 * (identity i j * (e i j * (v i * v j))) - Rabs (e i j)
      * (v i * v i + v j * v j) / 2))).
  2: { unfold form, bilinear, apply, over_reals. apply sum_le. intros i I. rewrite <- sum_times. apply sum_le.
    intros j J. fold (e i j). unfold identity. destruct (Nat.eqb_spec i j) as [<-|N].
    - assert (0 <= e i i).
      { specialize (D i I). fold (e i i) in D.
        assert (0 <= sum n (fun k => Rabs (IZR (get E i k)) + Rabs (IZR (get E k i)))); [|lra].
        apply sum_nonnegative. intros k _. pose proof (Rabs_pos (IZR (get E i k))).
          pose proof (Rabs_pos (IZR (get E k i))). lra. }
      rewrite Rabs_pos_eq by assumption. apply Req_le. field.
    - pose proof (below_product (e i j) (v i) (v j)). lra. }
  apply Rle_trans with
    (sum n (fun i => v i * v i * (4 * e i i - sum n (fun j => Rabs (e i j) + Rabs (e j i))) / 2)).
  { apply sum_nonnegative. intros i L. specialize (D i L). fold (e i i) in D.
    assert (0 <= v i * v i) by apply Rle_0_sqr.
    change (sum n (fun j => Rabs (e i j) + Rabs (e j i)) <= 4 * e i i) in D.
    assert (0 <= v i * v i * (4 * e i i - sum n (fun j => Rabs (e i j) + Rabs (e j i)))) by (apply Rmult_le_pos; lra).
    lra. }
  apply Req_le.
  transitivity (sum n (fun i => 2 * (e i i * (v i * v i))) - sum n (fun i => sum n (fun j => Rabs (e i j)
    * (v i * v i + v j * v j) / 2))).
  2: { rewrite <- sum_minus. apply sum_ext. intros i L. rewrite sum_minus, sum_times. f_equal. f_equal.
    symmetry. apply (sum_delta n (fun j => e i j * (v i * v j))), L. }
  assert (X : sum n (fun i => sum n (fun j => Rabs (e i j) * (v i * v i + v j * v j) / 2))
            = sum n (fun i => v i * v i * sum n (fun j => Rabs (e i j) + Rabs (e j i)) / 2)).
  { transitivity (sum n (fun i => sum n (fun j => Rabs (e i j) * (v i * v i) / 2))
    + sum n (fun i => sum n (fun j => Rabs (e j i) * (v i * v i) / 2))).
    - rewrite (sum_exchange n n (fun i j => Rabs (e j i) * (v i * v i) / 2)), <- sum_plus. apply sum_ext. intros i _.
      rewrite <- sum_plus. apply sum_ext. intros j _. lra.
    - rewrite <- sum_plus. apply sum_ext. intros i _. rewrite <- sum_plus.
      transitivity (sum n (fun j => (v i * v i / 2) * (Rabs (e i j) + Rabs (e j i)))).
      + apply sum_ext. intros j _. lra.
      + rewrite sum_times. lra. }
  rewrite X, <- sum_minus. apply sum_ext. intros i _. lra.
Qed.

(** ** With an approximate Cholesky factor *)

Fixpoint dot (r s : list Z) : Z :=
  match r, s with x :: r', y :: s' => x * y + dot r' s' | _, _ => 0 end%Z.

Lemma dot_correct n : forall r s, (length r <= n)%nat ->
  IZR (dot r s) = sum n (fun k => IZR (nth k r 0%Z) * IZR (nth k s 0%Z)).
Proof.
  induction n as [|n IH]; intros r s L.
  - destruct r; [reflexivity|simpl in L; lia].
  - rewrite sum_shift. destruct r as [|x r].
    + simpl. rewrite (sum_ext n _ (fun _ => 0)), sum_zero; [lra|]. intros i _. destruct i; lra.
    + destruct s as [|y s].
      * simpl. rewrite (sum_ext n _ (fun _ => 0)), sum_zero; [lra|]. intros i _. destruct i; lra.
      * simpl dot. rewrite plus_IZR, mult_IZR, (IH r s) by (simpl in L; lia). reflexivity.
Qed.

(** The next row of the factor: those above are [rows], s is the row of the matrix, the first entries are [found]. *)
Fixpoint cholesky_row (rows : list (list Z)) (j : nat) (s : nat -> Z) (found : list Z) : list Z :=
  match rows with
  | [] => found ++ [Z.sqrt (s j - dot found found)]
  | row :: rest => cholesky_row rest (S j) s (found ++ [((s j - dot found row) / nth j row 0)%Z])
  end.

Definition cholesky (n : nat) (M : list (list Z)) : list (list Z) :=
  fold_left (fun rows i => rows ++ [cholesky_row rows 0 (get M i) []]) (seq 0 n) [].

(** Powers of two that bring the diagonal to the same size, 2 top bits with top >= 96, and top. *)
Definition weights (n : nat) (M : list (list Z)) : list Z * Z :=
  let halves := map (fun i => Z.log2 (get M i i) / 2)%Z (seq 0 n) in
  let top := fold_left Z.max halves 96%Z in
  (map (fun half => 2 ^ (top - half))%Z halves, top).

(** G is the factor of the upper 192 bits of the weighted matrix, less what rounding can take. *)
Definition by_factor (n : nat) (M : list (list Z)) : bool :=
  let '(w, top) := weights n M in
  let weight i := nth i w 0%Z in
  let unit := (2 ^ (2 * (top - 96)))%Z in
  let slack := (Z.of_nat n * 2 ^ 98)%Z in
  let scaled := table n n (fun i j => weight i * weight j * get M i j)%Z in
  let upper := table n n (fun i j => get scaled i j / unit - (if Nat.eqb i j then slack else 0))%Z in
  let G := cholesky n upper in
  (0 <=? unit)%Z
    &&& all n (fun i => negb (weight i =? 0)%Z &&& Nat.leb (length (nth i G [])) n)
    &&& dominant n (table n n (fun i j => get scaled i j - unit * dot (nth i G []) (nth j G []))%Z).

Lemma gram_nonnegative n (G : nat -> nat -> R) v :
  form n (fun i j => sum n (fun k => G i k * G j k)) v
  = sum n (fun k => sum n (fun i => v i * G i k) * sum n (fun i => v i * G i k)).
Proof.
  unfold form, bilinear, apply.
  transitivity (sum n (fun i => sum n (fun k => v i * G i k * sum n (fun j => v j * G j k)))).
  - apply sum_ext. intros i _. rewrite <- sum_times.
    transitivity (sum n (fun j => sum n (fun k => v i * G i k * (v j * G j k)))).
    + apply sum_ext. intros j _. rewrite <- sum_times_right, <- sum_times. apply sum_ext. intros k _. ring.
    + rewrite sum_exchange. apply sum_ext. intros k _. apply sum_times.
  - rewrite sum_exchange. apply sum_ext. intros k _. apply sum_times_right.
Qed.

Lemma by_factor_correct n M v : by_factor n M = true -> 0 <= form n (over_reals M) v.
Proof.
  unfold by_factor. destruct (weights n M) as [w top]. set (unit := (2 ^ (2 * (top - 96)))%Z).
  set (scaled := table n n (fun i j => nth i w 0 * nth j w 0 * get M i j)%Z).
  set (G := cholesky n _).
  set (E := table n n (fun i j => get scaled i j - unit * dot (nth i G []) (nth j G []))%Z).
  intros H. apply both in H. destruct H as [Hw H]. apply both in Hw. destruct Hw as [Unit Hw].
  apply Z.leb_le, IZR_le in Unit.
  assert (K : forall i, (i < n)%nat -> IZR (nth i w 0%Z) <> 0 /\ (length (nth i G []) <= n)%nat).
  { intros i L. apply (all_correct _ _ i) in Hw; [|exact L]. apply both in Hw. destruct Hw as [A B]. split.
    - apply negb_true_iff, Z.eqb_neq in A. apply not_0_IZR. exact A.
    - apply Nat.leb_le. exact B. }
  set (u := fun i => v i / IZR (nth i w 0%Z)).
  apply (dominant_correct n E u) in H.
  set (g := fun i k => IZR (nth k (nth i G []) 0%Z)).
  set (gram := fun i j => sum n (fun k => g i k * g j k)).
  assert (S : form n (over_reals M) v = form n (plus (over_reals E) (scale (IZR unit) gram)) u).
  { unfold form, bilinear, apply. apply sum_ext. intros i I. rewrite <- !sum_times. apply sum_ext. intros j J.
    destruct (K i I) as [Wi Li]. destruct (K j J) as [Wj _].
    unfold plus, scale, over_reals, E. rewrite get_table, minus_IZR, (mult_IZR unit) by assumption.
    rewrite (dot_correct n _ _ Li). fold (g i). fold (gram i j). unfold scaled. rewrite get_table,
      !mult_IZR by assumption.
    unfold u, gram, g. field. split; assumption. }
  rewrite S. unfold form. rewrite bilinear_plus, bilinear_scale. fold (form n (over_reals E) u) (form n gram u).
  unfold gram at 1. rewrite gram_nonnegative.
  assert (0 <= IZR unit * sum n (fun k => sum n (fun i => u i * g i k) * sum n (fun i => u i * g i k))).
  { apply Rmult_le_pos; [exact Unit|]. apply sum_nonnegative. intros. apply Rle_0_sqr. }
  lra.
Qed.

(** ** By exact elimination *)

Fixpoint by_elimination (n : nat) (previous : Z) (M : list (list Z)) : bool :=
  match n with
  | O => true
  | S k =>
      let a := get M 0 0 in
      all k (fun i => get M (S i) 0 =? get M 0 (S i))%Z
        &&& if (a =? 0)%Z
           then all k (fun i => get M 0 (S i) =? 0)%Z
                  &&& by_elimination k previous (table k k (fun i j => get M (S i) (S j)))
           else let rest := table k k (fun i j => a * get M (S i) (S j) - get M (S i) 0 * get M 0 (S j))%Z in
                let next := table k k (fun i j => get rest i j / previous)%Z in
                (0 <? a)%Z
                  &&& all k (fun i => all k (fun j => previous * get next i j =? get rest i j)%Z)
                  &&& by_elimination k a next
  end.

(** A form, its first variable apart. *)
Lemma form_first n (M : matrix) v :
  form (S n) M v = M 0%nat 0%nat * (v 0%nat * v 0%nat)
    + v 0%nat * sum n (fun j => (M 0%nat (S j) + M (S j) 0%nat) * v (S j))
    + form n (fun i j => M (S i) (S j)) (fun i => v (S i)).
Proof.
  unfold form, bilinear. rewrite sum_shift. unfold apply. rewrite sum_shift.
  rewrite (sum_ext n (fun i => v (S i) * sum (S n) (fun j => M (S i) j * v j))
             (fun i => v 0%nat * (M (S i) 0%nat * v (S i)) + v (S i) * sum n (fun j => M (S i) (S j) * v (S j)))).
  2: { intros i _. rewrite sum_shift. ring. }
  rewrite sum_plus, sum_times.
  rewrite (sum_ext n (fun j => (M 0%nat (S j) + M (S j) 0%nat) * v (S j)) (fun j => M 0%nat (S j) * v (S j) + M (S j)
    0%nat * v (S j))).
  2: { intros; ring. }
  rewrite sum_plus. ring.
Qed.

Lemma square_of_sum n f g :
  sum n (fun i => f i * sum n (fun j => g j)) = sum n f * sum n g.
Proof. rewrite sum_times_right. reflexivity. Qed.

Lemma by_elimination_correct n : forall previous M v,
  (0 < previous)%Z -> by_elimination n previous M = true -> 0 <= form n (over_reals M) v.
Proof.
  induction n as [|n IH]; intros previous M v Positive H; [apply Rle_refl|].
  cbn [by_elimination] in H. apply both in H. destruct H as [Symmetric H].
  assert (Hs : forall i, (i < n)%nat -> get M (S i) 0 = get M 0 (S i)).
  { intros i L. apply (all_correct _ _ i) in Symmetric; [|exact L]. apply Z.eqb_eq. exact Symmetric. }
  rewrite form_first. set (w := fun i => v (S i)). set (a := get M 0 0) in *.
  destruct (Z.eqb_spec a 0) as [Zero|Nonzero].
  - apply both in H. destruct H as [Row H]. apply (IH _ _ w Positive) in H.
    rewrite (sum_ext n _ (fun _ => 0)), sum_zero.
    2: { intros j L. unfold over_reals. rewrite (Hs j L). apply (all_correct _ _ j) in Row; [|exact L].
      apply Z.eqb_eq in Row. rewrite Row. lra. }
    unfold over_reals at 1. fold a. rewrite Zero.
    rewrite (form_ext n _ (over_reals (table n n (fun i j => get M (S i) (S j)))) w w); [|intros i j I J|reflexivity].
    + lra.
    + unfold over_reals. rewrite get_table by assumption. reflexivity.
  - set (rest := table n n (fun i j => a * get M (S i) (S j) - get M (S i) 0 * get M 0 (S j))%Z) in *.
    set (next := table n n (fun i j => get rest i j / previous)%Z) in *.
    apply both in H. destruct H as [H Next]. apply both in H. destruct H as [Pivot Exact].
    apply Z.ltb_lt in Pivot. apply (IH _ _ w Pivot) in Next. apply IZR_lt in Pivot. apply IZR_lt in Positive.
    set (b := fun j => IZR (get M 0 (S j))).
    assert (R : form n (over_reals rest) w = IZR previous * form n (over_reals next) w).
    { unfold form. rewrite <- bilinear_scale. apply bilinear_ext; [intros i j I J|reflexivity|reflexivity].
      unfold scale, over_reals. rewrite <- mult_IZR. f_equal.
      apply (all_correct _ _ i) in Exact; [|exact I]. apply (all_correct _ _ j) in Exact; [|exact J].
      apply Z.eqb_eq in Exact. symmetry. exact Exact. }
    assert (Q : form n (over_reals rest) w
              = IZR a * form n (fun i j => over_reals M (S i) (S j)) w - sum n (fun j => b j * w j)
                * sum n (fun j => b j * w j)).
    { transitivity (form n (minus (scale (IZR a) (fun i j => over_reals M (S i) (S j))) (fun i j => b i * b j)) w).
      - apply form_ext; [intros i j I J|reflexivity]. unfold over_reals, rest, minus, scale.
        rewrite get_table, minus_IZR, !mult_IZR by assumption. rewrite (Hs i I). reflexivity.
      - unfold form. rewrite bilinear_minus, bilinear_scale. f_equal.
        unfold bilinear, apply. rewrite <- sum_times_right. apply sum_ext. intros i _.
        rewrite (sum_ext n (fun j => b i * b j * w j) (fun j => b i * (b j * w j))) by (intros; ring).
        rewrite sum_times. ring. }
    rewrite (sum_ext n _ (fun j => 2 * (b j * w j))), sum_times.
    2: { intros j L. unfold over_reals, b, w. rewrite (Hs j L). ring. }
    unfold over_reals at 1. fold a.
    set (s := sum n (fun j => b j * w j)) in *. set (f := form n (fun i j => over_reals M (S i) (S j)) w) in *.
    assert (0 <= IZR previous * form n (over_reals next) w) by (apply Rmult_le_pos; lra).
    apply Rmult_le_reg_l with (IZR a); [exact Pivot|]. rewrite Rmult_0_r.
    replace (IZR a * (IZR a * (v 0%nat * v 0%nat) + v 0%nat * (2 * s) + f))
      with ((IZR a * v 0%nat + s) * (IZR a * v 0%nat + s) + (IZR a * f - s * s)) by ring.
    assert (0 <= (IZR a * v 0%nat + s) * (IZR a * v 0%nat + s)) by apply Rle_0_sqr. lra.
Qed.

(** ** Matrices over a denominator *)

Definition numbers : Type := list (list Z) * positive.

Definition value (X : numbers) : matrix := fun i j => IZR (get (fst X) i j) / IZR (Zpos (snd X)).

Lemma denominator_positive (X : numbers) : 0 < IZR (Zpos (snd X)).
Proof. apply IZR_lt. reflexivity. Qed.

(** The entries of X are those of M. *)
Definition equals (n m : nat) (X : numbers) (M : matrix) : Prop := same n m (value X) M.

Definition semidefinite (n : nat) (X : numbers) : bool := by_factor n (fst X) ||| by_elimination n 1 (fst X).

Theorem semidefinite_correct n X M :
  equals n n X M -> semidefinite n X = true -> forall v, 0 <= form n M v.
Proof.
  intros E H v. rewrite <- (form_ext n (value X) M v v E) by reflexivity.
  assert (K : 0 <= form n (over_reals (fst X)) v).
  { apply one_of in H. destruct H as [H|H].
    - apply by_factor_correct. exact H.
    - apply (by_elimination_correct n 1 _ _ eq_refl H). }
  replace (form n (value X) v) with (/ IZR (Zpos (snd X)) * form n (over_reals (fst X)) v).
  - apply Rmult_le_pos; [|exact K]. apply Rlt_le, Rinv_0_lt_compat, denominator_positive.
  - unfold form. rewrite <- bilinear_scale. apply bilinear_ext; try reflexivity.
    intros i j _ _. unfold scale, value, over_reals. unfold Rdiv. ring.
Qed.

(** Rational numbers, over a common denominator. *)

Definition common_denominator (n m : nat) (A : list (list Q)) : positive :=
  fold_left (fun d i => fold_left (fun d j =>
    let b := Zpos (Qden (entry A i j)) in
    if (Zpos d mod b =? 0)%Z then d else Z.to_pos (Z.lcm (Zpos d) b)) (seq 0 m) d) (seq 0 n) 1%positive.

Definition numbers_of (n m : nat) (A : list (list Q)) : numbers :=
  let d := common_denominator n m A in
  (table n m (fun i j => let q := entry A i j in Qnum q * (Zpos d / Zpos (Qden q)))%Z, d).

Definition are_exact (n m : nat) (A : list (list Q)) (X : numbers) : bool :=
  all n (fun i => all m (fun j =>
    let q := entry A i j in Qnum q * Zpos (snd X) =? get (fst X) i j * Zpos (Qden q))%Z).

Lemma are_exact_correct n m A X : are_exact n m A X = true -> equals n m X (real A).
Proof.
  intros H i j I J. apply (all_correct _ _ i) in H; [|exact I]. apply (all_correct _ _ j) in H; [|exact J].
  apply Z.eqb_eq in H. unfold value, real, Q2R.
  pose proof (denominator_positive X). assert (0 < IZR (Zpos (Qden (entry A i j)))) by (apply IZR_lt; reflexivity).
  assert (K : IZR (Qnum (entry A i j)) * IZR (Zpos (snd X)) = IZR (get (fst X) i j) * IZR (Zpos (Qden (entry A i j)))).
  { rewrite <- !mult_IZR. f_equal. exact H. }
  apply Rmult_eq_reg_r with (IZR (Zpos (snd X)) * IZR (Zpos (Qden (entry A i j)))).
  - field_simplify; [|lra|lra]. lra.
  - apply Rgt_not_eq, Rmult_lt_0_compat; assumption.
Qed.

(** ** Sums and products *)

Definition times (n k m : nat) (X Y : numbers) : numbers :=
  (table n m (fun i j => zsum k (fun l => get (fst X) i l * get (fst Y) l j)%Z), (snd X * snd Y)%positive).

Lemma times_correct n k m X Y A B :
  equals n k X A -> equals k m Y B -> equals n m (times n k m X Y) (product k A B).
Proof.
  intros HX HY i j I J. unfold value. cbn [fst snd times]. rewrite get_table, IZR_zsum by assumption.
  unfold product, Rdiv. rewrite <- sum_times_right. apply sum_ext. intros l L.
  rewrite <- HX, <- HY by assumption. unfold value. rewrite Pos2Z.inj_mul, !mult_IZR.
  pose proof (denominator_positive X). pose proof (denominator_positive Y). field. split; lra.
Qed.

Definition turned (n m : nat) (X : numbers) : numbers := (table n m (fun i j => get (fst X) j i), snd X).

Lemma turned_correct n m X A : equals m n X A -> equals n m (turned n m X) (transpose A).
Proof.
  intros H i j I J. unfold value. cbn [fst snd turned]. rewrite get_table by assumption. apply (H j i J I).
Qed.

Definition added (n m : nat) (X Y : numbers) : numbers :=
  (table n m (fun i j => get (fst X) i j * Zpos (snd Y) + get (fst Y) i j * Zpos (snd X))%Z, (snd X * snd Y)%positive).

Lemma added_correct n m X Y A B : equals n m X A -> equals n m Y B -> equals n m (added n m X Y) (plus A B).
Proof.
  intros HX HY i j I J. unfold value. cbn [fst snd added]. rewrite get_table by assumption.
  unfold plus. rewrite <- HX, <- HY by assumption. unfold value.
  rewrite Pos2Z.inj_mul, plus_IZR, !mult_IZR.
  pose proof (denominator_positive X). pose proof (denominator_positive Y). field. split; lra.
Qed.

(** [q X] for a rational number q. *)
Definition multiple (n m : nat) (q : Q) (X : numbers) : numbers :=
  (table n m (fun i j => Qnum q * get (fst X) i j)%Z, (Qden q * snd X)%positive).

Lemma multiple_correct n m q X A : equals n m X A -> equals n m (multiple n m q X) (scale (Q2R q) A).
Proof.
  intros H i j I J. unfold value. cbn [fst snd multiple]. rewrite get_table by assumption.
  unfold scale. rewrite <- H by assumption. unfold value, Q2R.
  rewrite Pos2Z.inj_mul, !mult_IZR. pose proof (denominator_positive X).
  assert (0 < IZR (Zpos (Qden q))) by (apply IZR_lt; reflexivity). field. split; lra.
Qed.

Definition negative (n m : nat) (X : numbers) : numbers := (table n m (fun i j => - get (fst X) i j)%Z, snd X).

Lemma negative_correct n m X A : equals n m X A -> equals n m (negative n m X) (scale (-1) A).
Proof.
  intros H i j I J. unfold value. cbn [fst snd negative]. rewrite get_table, opp_IZR by assumption.
  unfold scale. rewrite <- H by assumption. unfold value, Rdiv. ring.
Qed.

Definition subtracted (n m : nat) (X Y : numbers) : numbers :=
  (table n m (fun i j => get (fst X) i j * Zpos (snd Y) - get (fst Y) i j * Zpos (snd X))%Z, (snd X * snd Y)%positive).

Lemma subtracted_correct n m X Y A B : equals n m X A -> equals n m Y B -> equals n m (subtracted n m X Y) (minus A B).
Proof.
  intros HX HY i j I J. unfold value. cbn [fst snd subtracted]. rewrite get_table by assumption.
  unfold minus. rewrite <- HX, <- HY by assumption. unfold value.
  rewrite Pos2Z.inj_mul, minus_IZR, !mult_IZR.
  pose proof (denominator_positive X). pose proof (denominator_positive Y). field. split; lra.
Qed.

(** [q I]. *)
Definition multiple_of_identity (n : nat) (q : Q) : numbers :=
  (table n n (fun i j => if Nat.eqb i j then Qnum q else 0)%Z, Qden q).

Lemma multiple_of_identity_correct n q : equals n n (multiple_of_identity n q) (scale (Q2R q) identity).
Proof.
  intros i j I J. unfold value. cbn [fst snd multiple_of_identity]. rewrite get_table by assumption.
  unfold scale, identity, Q2R, Rdiv. destruct (Nat.eqb i j); ring.
Qed.

(** ** Shorter numbers *)

Fixpoint trailing_zeros (p : positive) : Z := match p with xO r => 1 + trailing_zeros r | _ => 0 end%Z.

(** The numbers without the powers of two that they have in common: products and sums multiply denominators. *)
Definition shortened (n m : nat) (X : numbers) : numbers :=
  let zeros z := match z with Z0 => None | Zpos p => Some (trailing_zeros p) | Zneg p => Some (trailing_zeros p) end in
  let least k z := match zeros z with None => k | Some l => Z.min k l end in
  let k := fold_left (fun k i => fold_left (fun k j => least k (get (fst X) i j)) (seq 0 m) k) (seq 0 n)
             (trailing_zeros (snd X)) in
  let Y := (table n m (fun i j => Z.shiftr (get (fst X) i j) k), Z.to_pos (Z.shiftr (Zpos (snd X)) k)) in
  if (Z.shiftl (Zpos (snd Y)) k =? Zpos (snd X))%Z
       &&& all n (fun i => all m (fun j => Z.shiftl (get (fst Y) i j) k =? get (fst X) i j)%Z)
       &&& (0 <=? k)%Z
  then Y else X.

Lemma shortened_correct n m X A : equals n m X A -> equals n m (shortened n m X) A.
Proof.
  intros E. unfold shortened. set (k := fold_left _ _ _).
  set (Y := (table n m (fun i j => Z.shiftr (get (fst X) i j) k), Z.to_pos (Z.shiftr (Zpos (snd X)) k))). cbv zeta.
  destruct ((Z.shiftl (Zpos (snd Y)) k =? Zpos (snd X))%Z
    &&& all n (fun i => all m (fun j => Z.shiftl (get (fst Y) i j) k =? get (fst X) i j)%Z) &&& (0 <=? k)%Z) eqn:H;
    [|exact E].
  apply both in H. destruct H as [H K]. apply both in H. destruct H as [Denominator Entries]. apply Z.leb_le in K.
    apply Z.eqb_eq in Denominator.
  intros i j I J. rewrite <- (E i j I J). unfold value.
  apply (all_correct _ _ i) in Entries; [|exact I]. apply (all_correct _ _ j) in Entries; [|exact J].
  apply Z.eqb_eq in Entries. rewrite <- Entries, <- Denominator, !Z.shiftl_mul_pow2, !mult_IZR by exact K.
  assert (0 < IZR (2 ^ k)) by (apply IZR_lt, Z.pow_pos_nonneg; lia). pose proof (denominator_positive Y).
  field. split; lra.
Qed.

(** ** Inequalities *)

(** [X >= q I] *)
Definition at_least (n : nat) (X : numbers) (q : Q) : bool :=
  semidefinite n (shortened n n (subtracted n n (shortened n n X) (multiple_of_identity n q))).

Lemma at_least_correct n X M q :
  equals n n X M -> at_least n X q = true -> forall v, Q2R q * square n v <= form n M v.
Proof.
  intros E H v.
  pose proof (semidefinite_correct n _ _ (shortened_correct _ _ _ _ (subtracted_correct _ _ _ _ _ _
    (shortened_correct _ _ _ _ E) (multiple_of_identity_correct n q))) H v) as K.
  unfold form in K. rewrite bilinear_minus, bilinear_scale in K. fold (form n M v) (form n identity v) in K.
  rewrite form_identity in K. lra.
Qed.
