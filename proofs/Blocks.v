(** Pairs of vectors and matrices in blocks, for statements about two vectors at once. *)

From Coq Require Import Reals QArith Qreals ZArith List Lra Lia.
From Luenberger Require Import Vectors Definite.
Import ListNotations.
Local Open Scope R_scope.

(** The vector of the n entries of x and then those of e. *)
Definition pair_of (n : nat) (x e : vector) : vector := fun i => if Nat.ltb i n then x i else e (i - n)%nat.

(** [[A B; C D]], A with n rows and n columns. *)
Definition blocks (n : nat) (A B C D : matrix) : matrix := fun i j =>
  if Nat.ltb i n then if Nat.ltb j n then A i j else B i (j - n)%nat
  else if Nat.ltb j n then C (i - n)%nat j else D (i - n)%nat (j - n)%nat.

Definition nothing : matrix := fun _ _ => 0.

Lemma pair_first n x e i : (i < n)%nat -> pair_of n x e i = x i.
Proof. intros L. unfold pair_of. destruct (Nat.ltb_spec i n); [reflexivity|lia]. Qed.

Lemma pair_second n x e i : pair_of n x e (n + i)%nat = e i.
Proof. unfold pair_of. destruct (Nat.ltb_spec (n + i) n); [lia|]. f_equal. lia. Qed.

Lemma sum_split n k f : sum (n + k) f = sum n f + sum k (fun i => f (n + i)%nat).
Proof.
  induction k as [|k IH]; [rewrite Nat.add_0_r; simpl; lra|]. rewrite Nat.add_succ_r. simpl. rewrite IH. lra.
Qed.

(** What is said of the entries of a pair is said of both. *)
Lemma each_of_pair n k (H : nat -> Prop) :
  (forall i, (i < n)%nat -> H i) -> (forall i, (i < k)%nat -> H (n + i)%nat) -> forall i, (i < n + k)%nat -> H i.
Proof.
  intros F S i L. destruct (Nat.ltb_spec i n) as [K|K]; [apply F, K|].
  replace i with (n + (i - n))%nat by lia. apply S. lia.
Qed.

Lemma square_pair n k x e : square (n + k) (pair_of n x e) = square n x + square k e.
Proof.
  unfold square. rewrite sum_split. f_equal.
  - apply sum_ext. intros i L. rewrite pair_first by exact L. reflexivity.
  - apply sum_ext. intros i _. rewrite pair_second. reflexivity.
Qed.

Lemma apply_blocks_first n k A B C D x e i :
  (i < n)%nat -> apply (n + k) (blocks n A B C D) (pair_of n x e) i = apply n A x i + apply k B e i.
Proof.
  intros L. unfold apply, blocks. rewrite sum_split. destruct (Nat.ltb_spec i n); [|lia]. f_equal.
  - apply sum_ext. intros j J. rewrite pair_first by exact J. destruct (Nat.ltb_spec j n); [reflexivity|lia].
  - apply sum_ext. intros j J. rewrite pair_second. destruct (Nat.ltb_spec (n + j) n); [lia|].
    replace (n + j - n)%nat with j by lia. reflexivity.
Qed.

Lemma apply_blocks_second n k A B C D x e i :
  apply (n + k) (blocks n A B C D) (pair_of n x e) (n + i)%nat = apply n C x i + apply k D e i.
Proof.
  unfold apply, blocks. rewrite sum_split. destruct (Nat.ltb_spec (n + i) n); [lia|].
  replace (n + i - n)%nat with i by lia. f_equal.
  - apply sum_ext. intros j J. rewrite pair_first by exact J. destruct (Nat.ltb_spec j n); [reflexivity|lia].
  - apply sum_ext. intros j J. rewrite pair_second. destruct (Nat.ltb_spec (n + j) n); [lia|].
    replace (n + j - n)%nat with j by lia. reflexivity.
Qed.

Lemma bilinear_blocks n k A B C D x e y f :
  bilinear (n + k) (n + k) (blocks n A B C D) (pair_of n x e) (pair_of n y f)
  = bilinear n n A x y + bilinear n k B x f + bilinear k n C e y + bilinear k k D e f.
Proof.
  unfold bilinear at 1. rewrite sum_split.
  rewrite (sum_ext n _ (fun i => x i * apply n A y i + x i * apply k B f i)).
  2: { intros i L. rewrite pair_first, apply_blocks_first by exact L. ring. }
  rewrite (sum_ext k _ (fun i => e i * apply n C y i + e i * apply k D f i)).
  2: { intros i _. rewrite pair_second, apply_blocks_second. ring. }
  rewrite !sum_plus. unfold bilinear. ring.
Qed.

Lemma bilinear_nothing n k x y : bilinear n k nothing x y = 0.
Proof.
  unfold bilinear, apply, nothing. rewrite (sum_ext n _ (fun _ => 0)); [apply sum_zero|]. intros i _.
  rewrite (sum_ext k _ (fun _ => 0)); [rewrite sum_zero|]; intros; ring.
Qed.

(** ** Numbers in blocks *)

Definition no_numbers : numbers := ([], 1%positive).

Lemma no_numbers_correct n m : equals n m no_numbers nothing.
Proof. intros i j _ _. unfold value, nothing, get. simpl. destruct i, j; simpl; lra. Qed.

Definition in_blocks (n k : nat) (X Y Z W : numbers) : numbers :=
  let '(x, y, z, w) := (snd X, snd Y, snd Z, snd W) in
  (table (n + k) (n + k) (fun i j =>
     if Nat.ltb i n then if Nat.ltb j n then get (fst X) i j * Zpos (y * z * w) else get (fst Y) i (j - n) * Zpos (x *
       z * w)
     else if Nat.ltb j n then get (fst Z) (i - n) j * Zpos (x * y * w)
     else get (fst W) (i - n) (j - n) * Zpos (x * y * z))%Z, (x * y * z * w)%positive).

Lemma over_common c d (r : R) z : IZR z / IZR (Zpos d) = r -> IZR (z * Zpos c) / IZR (Zpos (d * c)) = r.
Proof.
  intros <-. rewrite Pos2Z.inj_mul, !mult_IZR. assert (0 < IZR (Zpos c)) by (apply IZR_lt; reflexivity).
  assert (0 < IZR (Zpos d)) by (apply IZR_lt; reflexivity). field. split; lra.
Qed.

Lemma in_blocks_correct n k X Y Z W A B C D :
  equals n n X A -> equals n k Y B -> equals k n Z C -> equals k k W D ->
  equals (n + k) (n + k) (in_blocks n k X Y Z W) (blocks n A B C D).
Proof.
  intros HX HY HZ HW i j I J. unfold value, in_blocks, blocks. cbn [fst snd]. rewrite get_table by assumption.
  destruct (Nat.ltb_spec i n) as [Hi|Hi], (Nat.ltb_spec j n) as [Hj|Hj].
  - replace (snd X * snd Y * snd Z * snd W)%positive with (snd X * (snd Y * snd Z * snd W))%positive by lia.
    apply over_common, (HX i j Hi Hj).
  - replace (snd X * snd Y * snd Z * snd W)%positive with (snd Y * (snd X * snd Z * snd W))%positive by lia.
    apply over_common, (HY i (j - n)%nat); lia.
  - replace (snd X * snd Y * snd Z * snd W)%positive with (snd Z * (snd X * snd Y * snd W))%positive by lia.
    apply over_common, (HZ (i - n)%nat j); lia.
  - replace (snd X * snd Y * snd Z * snd W)%positive with (snd W * (snd X * snd Y * snd Z))%positive by lia.
    apply over_common, (HW (i - n)%nat (j - n)%nat); lia.
Qed.
