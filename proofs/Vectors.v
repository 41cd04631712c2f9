(** Vectors and matrices of real numbers.

    A vector is a function of the index, a matrix one of row and column; both count from 0. How many of the entries are
    meant is said where they are summed: [sum n f] is [f 0 + ... + f (n-1)]. A matrix of numbers is a list of rows of
    rational numbers, as the certificate has them; [real A] is the same over the real numbers. *)

From Coq Require Import Reals QArith Qreals List Lra Lia.
Import ListNotations.
Local Open Scope R_scope.

(** ** Sums *)

Fixpoint sum (n : nat) (f : nat -> R) : R :=
  match n with O => 0 | S k => sum k f + f k end.

Lemma sum_ext n f g : (forall i, (i < n)%nat -> f i = g i) -> sum n f = sum n g.
Proof. induction n as [|n IH]; intros H; simpl; [reflexivity|]. rewrite IH, H; [reflexivity|lia|intros; apply H; lia].
  Qed.

Lemma sum_plus n f g : sum n (fun i => f i + g i) = sum n f + sum n g.
Proof. induction n as [|n IH]; simpl; [lra|]. rewrite IH; lra. Qed.

Lemma sum_times n c f : sum n (fun i => c * f i) = c * sum n f.
Proof. induction n as [|n IH]; simpl; [lra|]. rewrite IH; lra. Qed.

Lemma sum_times_right n c f : sum n (fun i => f i * c) = sum n f * c.
Proof. induction n as [|n IH]; simpl; [lra|]. rewrite IH; lra. Qed.

Lemma sum_minus n f g : sum n (fun i => f i - g i) = sum n f - sum n g.
Proof. induction n as [|n IH]; simpl; [lra|]. rewrite IH; lra. Qed.

Lemma sum_zero n : sum n (fun _ => 0) = 0.
Proof. induction n as [|n IH]; simpl; lra. Qed.

Lemma sum_exchange n m f : sum n (fun i => sum m (fun j => f i j)) = sum m (fun j => sum n (fun i => f i j)).
Proof.
  induction n as [|n IH]; simpl; [symmetry; apply sum_zero|]. rewrite IH, <- sum_plus. reflexivity.
Qed.

Lemma sum_le n f g : (forall i, (i < n)%nat -> f i <= g i) -> sum n f <= sum n g.
Proof.
  induction n as [|n IH]; intros H; simpl; [lra|]. specialize (IH (fun i L => H i ltac:(lia))).
  specialize (H n ltac:(lia)). lra.
Qed.

Lemma sum_nonnegative n f : (forall i, (i < n)%nat -> 0 <= f i) -> 0 <= sum n f.
Proof. intros H. rewrite <- (sum_zero n). apply sum_le, H. Qed.

Lemma sum_shift n f : sum (S n) f = f 0%nat + sum n (fun i => f (S i)).
Proof. induction n as [|n IH]; [simpl; lra|]. change (sum (S (S n)) f) with (sum (S n) f + f (S n)). rewrite IH.
  simpl. lra. Qed.

(** Of a sum without negative terms each term is a part. *)
Lemma term_le_sum n f i : (forall j, (j < n)%nat -> 0 <= f j) -> (i < n)%nat -> f i <= sum n f.
Proof.
  induction n as [|n IH]; intros H L; [lia|]. simpl.
  assert (0 <= sum n f) by (apply sum_nonnegative; intros; apply H; lia).
  destruct (Nat.eq_dec i n) as [->|N]; [lra|].
  specialize (IH (fun j J => H j ltac:(lia)) ltac:(lia)). specialize (H n ltac:(lia)). lra.
Qed.

(** ** Vectors and matrices *)

Definition vector := nat -> R.
Definition matrix := nat -> nat -> R.

(** [A x], the product of a matrix with m columns and a vector. *)
Definition apply (m : nat) (A : matrix) (x : vector) : vector := fun i => sum m (fun j => A i j * x j).

(** [x'M y], for vectors of n and m entries. *)
Definition bilinear (n m : nat) (M : matrix) (x y : vector) : R := sum n (fun i => x i * apply m M y i).

(** [x'M x]. *)
Definition form (n : nat) (M : matrix) (x : vector) : R := bilinear n n M x x.

(** [|x|^2], the square of the Euclidean norm. *)
Definition square (n : nat) (x : vector) : R := sum n (fun i => x i * x i).

Definition transpose (A : matrix) : matrix := fun i j => A j i.
Definition product (k : nat) (A B : matrix) : matrix := fun i j => sum k (fun l => A i l * B l j).
Definition plus (A B : matrix) : matrix := fun i j => A i j + B i j.
Definition minus (A B : matrix) : matrix := fun i j => A i j - B i j.
Definition scale (c : R) (A : matrix) : matrix := fun i j => c * A i j.
Definition identity : matrix := fun i j => if Nat.eqb i j then 1 else 0.

(** Matrices that agree in their first n rows and m columns. *)
Definition same (n m : nat) (A B : matrix) : Prop := forall i j, (i < n)%nat -> (j < m)%nat -> A i j = B i j.

Lemma apply_ext m A B x y i :
  (forall j, (j < m)%nat -> A i j = B i j) -> (forall j, (j < m)%nat -> x j = y j) -> apply m A x i = apply m B y i.
Proof. intros H K. apply sum_ext. intros j L. rewrite H, K by exact L. reflexivity. Qed.

Lemma bilinear_ext n m A B x y v w :
  same n m A B -> (forall i, (i < n)%nat -> x i = v i) -> (forall j, (j < m)%nat -> y j = w j) ->
  bilinear n m A x y = bilinear n m B v w.
Proof.
  intros H K L. apply sum_ext. intros i I. rewrite K by exact I. f_equal. apply apply_ext; [intros j J; apply H|];
    assumption.
Qed.

Lemma form_ext n A B x y : same n n A B -> (forall i, (i < n)%nat -> x i = y i) -> form n A x = form n B y.
Proof. intros H K. apply bilinear_ext; assumption. Qed.

Lemma bilinear_plus n m A B x y : bilinear n m (plus A B) x y = bilinear n m A x y + bilinear n m B x y.
Proof.
  unfold bilinear, apply, plus. rewrite <- sum_plus. apply sum_ext. intros i _.
  rewrite <- Rmult_plus_distr_l. f_equal. rewrite <- sum_plus. apply sum_ext. intros j _. ring.
Qed.

Lemma bilinear_minus n m A B x y : bilinear n m (minus A B) x y = bilinear n m A x y - bilinear n m B x y.
Proof.
  unfold bilinear, apply, minus. rewrite <- sum_minus. apply sum_ext. intros i _.
  rewrite <- Rmult_minus_distr_l. f_equal. rewrite <- sum_minus. apply sum_ext. intros j _. ring.
Qed.

Lemma bilinear_scale n m c A x y : bilinear n m (scale c A) x y = c * bilinear n m A x y.
Proof.
  unfold bilinear, apply, scale. rewrite <- sum_times. apply sum_ext. intros i _.
  rewrite <- Rmult_assoc, (Rmult_comm c), Rmult_assoc. f_equal. rewrite <- sum_times. apply sum_ext. intros j _. ring.
Qed.

Lemma bilinear_transpose n m A x y : bilinear n m (transpose A) x y = bilinear m n A y x.
Proof.
  unfold bilinear, apply, transpose.
  transitivity (sum n (fun i => sum m (fun j => x i * (A j i * y j)))).
  - apply sum_ext. intros i _. symmetry. apply sum_times.
  - rewrite sum_exchange. apply sum_ext. intros j _. rewrite <- sum_times. apply sum_ext. intros i _. ring.
Qed.

Lemma apply_product k m A B x i : apply m (product k A B) x i = apply k A (apply m B x) i.
Proof.
  unfold apply, product.
  transitivity (sum m (fun j => sum k (fun l => A i l * (B l j * x j)))).
  - apply sum_ext. intros j _. rewrite <- sum_times_right. apply sum_ext. intros l _. ring.
  - rewrite sum_exchange. apply sum_ext. intros l _. apply sum_times.
Qed.

Lemma bilinear_product n k m A B x y : bilinear n m (product k A B) x y = bilinear n k A x (apply m B y).
Proof. apply sum_ext. intros i _. f_equal. apply apply_product. Qed.

(** [x'A'M y = (Ax)'M y] for A with k rows and n columns. *)
Lemma bilinear_transpose_product n k m A M x y :
  bilinear n m (product k (transpose A) M) x y = bilinear k m M (apply n A x) y.
Proof.
  rewrite bilinear_product, bilinear_transpose. unfold bilinear.
  apply sum_ext. intros i _. apply Rmult_comm.
Qed.

Lemma apply_plus m A B x i : apply m (plus A B) x i = apply m A x i + apply m B x i.
Proof. unfold apply, plus. rewrite <- sum_plus. apply sum_ext. intros; ring. Qed.

Lemma apply_minus m A B x i : apply m (minus A B) x i = apply m A x i - apply m B x i.
Proof. unfold apply, minus. rewrite <- sum_minus. apply sum_ext. intros; ring. Qed.

Lemma apply_minus_vector m A x y i : apply m A (fun j => x j - y j) i = apply m A x i - apply m A y i.
Proof. unfold apply. rewrite <- sum_minus. apply sum_ext. intros; ring. Qed.

Lemma apply_scale_vector m A c x i : apply m A (fun j => c * x j) i = c * apply m A x i.
Proof. unfold apply. rewrite <- sum_times. apply sum_ext. intros; ring. Qed.

Lemma bilinear_plus_left n m M x y z :
  bilinear n m M (fun i => x i + y i) z = bilinear n m M x z + bilinear n m M y z.
Proof. unfold bilinear. rewrite <- sum_plus. apply sum_ext. intros; ring. Qed.

Lemma bilinear_plus_right n m M x y z :
  bilinear n m M x (fun i => y i + z i) = bilinear n m M x y + bilinear n m M x z.
Proof. rewrite <- !(bilinear_transpose _ _ M), bilinear_plus_left. reflexivity. Qed.

Lemma bilinear_scale_left n m M c x y : bilinear n m M (fun i => c * x i) y = c * bilinear n m M x y.
Proof. unfold bilinear. rewrite <- sum_times. apply sum_ext. intros; ring. Qed.

Lemma bilinear_scale_right n m M c x y : bilinear n m M x (fun i => c * y i) = c * bilinear n m M x y.
Proof. rewrite <- !(bilinear_transpose _ _ M). apply bilinear_scale_left. Qed.

Lemma sum_delta n f i : (i < n)%nat -> sum n (fun j => identity i j * f j) = f i.
Proof.
  unfold identity. induction n as [|n IH]; intros L; [lia|]. simpl.
  destruct (Nat.eq_dec i n) as [->|N].
  - rewrite Nat.eqb_refl, (sum_ext n _ (fun _ => 0)), sum_zero; [lra|].
    intros j J. destruct (Nat.eqb_spec n j); [lia|lra].
  - rewrite IH by lia. destruct (Nat.eqb_spec i n); [lia|lra].
Qed.

Lemma form_identity n x : form n identity x = square n x.
Proof. apply sum_ext. intros i L. f_equal. apply sum_delta, L. Qed.

Lemma square_nonnegative n x : 0 <= square n x.
Proof. apply sum_nonnegative. intros. apply Rle_0_sqr. Qed.

Lemma square_positive n x i : (i < n)%nat -> x i <> 0 -> 0 < square n x.
Proof.
  intros L H. apply Rlt_le_trans with (x i * x i).
  - apply Rsqr_pos_lt in H. exact H.
  - apply (term_le_sum n (fun j => x j * x j)); [|exact L]. intros. apply Rle_0_sqr.
Qed.

(** ** Matrices of rational numbers *)

(** Entry of row i and column j; 0 beyond the rows. *)
Definition entry (A : list (list Q)) (i j : nat) : Q := nth j (nth i A []) 0%Q.

Definition real (A : list (list Q)) : matrix := fun i j => Q2R (entry A i j).

(** The product of a matrix of numbers and a vector, over all columns that the matrix has. *)
Definition times_vector (A : list (list Q)) (x : vector) : vector :=
  fun i => sum (length (nth i A [])) (fun j => real A i j * x j).

Definition plus_vector (x y : vector) : vector := fun i => x i + y i.
Definition minus_vector (x y : vector) : vector := fun i => x i - y i.

Definition scale_vector (c : R) (x : vector) : vector := fun i => c * x i.

Declare Scope vector_scope.
Delimit Scope vector_scope with vector.
Bind Scope vector_scope with vector.
Notation "A * x" := (times_vector A x) : vector_scope.
Notation "x + y" := (plus_vector x y) : vector_scope.
Notation "x - y" := (minus_vector x y) : vector_scope.
Notation "c .* x" := (scale_vector c x) (at level 40, left associativity) : vector_scope.

(** [x'y] *)
Definition inner (n : nat) (x y : vector) : R := sum n (fun i => x i * y i).

(** [x'M x] *)
Definition quadratic (n : nat) (M : list (list Q)) (x : vector) : R := inner n x (M * x)%vector.

(** The Euclidean norm. *)
Definition norm (n : nat) (x : vector) : R := sqrt (square n x).

(** A matrix of n rows and m columns. *)
Definition has_shape (n m : nat) (A : list (list Q)) : bool :=
  Nat.eqb (length A) n && forallb (fun row => Nat.eqb (length row) m) A.

Lemma has_shape_row n m A i : has_shape n m A = true -> (i < n)%nat -> length (nth i A []) = m.
Proof.
  intros H L. apply andb_prop in H. destruct H as [N R]. apply Nat.eqb_eq in N. rewrite forallb_forall in R.
  apply Nat.eqb_eq, R, nth_In. lia.
Qed.

Lemma times_vector_apply n m A x i :
  has_shape n m A = true -> (i < n)%nat -> times_vector A x i = apply m (real A) x i.
Proof. intros H L. unfold times_vector. rewrite (has_shape_row n m A i H L). reflexivity. Qed.

Lemma quadratic_form n M x : has_shape n n M = true -> quadratic n M x = form n (real M) x.
Proof. intros H. apply sum_ext. intros i L. f_equal. apply (times_vector_apply n); assumption. Qed.

Lemma inner_bilinear n M x y : has_shape n n M = true -> inner n x (M * y)%vector = bilinear n n (real M) x y.
Proof. intros H. apply sum_ext. intros i L. f_equal. apply (times_vector_apply n); assumption. Qed.
