(** Linear equations over the real numbers: fewer equations than unknowns have a solution that is not 0, and with a
    positive definite matrix every equation has a solution. *)

From Coq Require Import Reals Lra Lia.
From Luenberger Require Import Vectors.
Local Open Scope R_scope.

(** The indices without i, in order. *)
Definition beyond (i j : nat) : nat := if Nat.ltb j i then j else S j.

Lemma sum_without n i f : (i <= n)%nat -> sum (S n) f = f i + sum n (fun j => f (beyond i j)).
Proof.
  induction n as [|n IH]; intros L.
  - replace i with 0%nat by lia. simpl. lra.
  - change (sum (S (S n)) f) with (sum (S n) f + f (S n)).
    change (sum (S n) (fun j => f (beyond i j))) with (sum n (fun j => f (beyond i j)) + f (beyond i n)).
    destruct (Nat.eq_dec i (S n)) as [->|D].
    + unfold beyond at 2. destruct (Nat.ltb_spec n (S n)); [|lia].
      rewrite (sum_ext n (fun j => f (beyond (S n) j)) f); [simpl; lra|].
      intros j J. unfold beyond. destruct (Nat.ltb_spec j (S n)); [reflexivity|lia].
    + rewrite IH by lia. unfold beyond at 3. destruct (Nat.ltb_spec n i); [lia|]. lra.
Qed.

Lemma row_is_zero_or_not n (c : nat -> R) :
  (forall j, (j < n)%nat -> c j = 0) \/ exists j, (j < n)%nat /\ c j <> 0.
Proof.
  induction n as [|n [IH|(j & L & H)]].
  - left. intros; lia.
  - destruct (Req_dec (c n) 0) as [E|N].
    + left. intros j L. destruct (Nat.eq_dec j n) as [->|D]; [exact E|apply IH; lia].
    + right. exists n. split; [lia|exact N].
  - right. exists j. split; [lia|exact H].
Qed.

(** p equations with more than p unknowns. *)
Theorem nullspace p : forall n (C : matrix), (p < n)%nat ->
  exists v : vector, 0 < square n v /\ forall i, (i < p)%nat -> apply n C v i = 0.
Proof.
  induction p as [|p IH]; intros n C L.
  - exists (fun _ => 1). split; [|intros; lia]. apply (square_positive n _ 0); [exact L|lra].
  - destruct (row_is_zero_or_not n (C p)) as [Zero|(k & K & N)].
    + destruct (IH n C) as (v & Positive & H); [lia|]. exists v. split; [exact Positive|]. intros i I.
      destruct (Nat.eq_dec i p) as [->|D]; [|apply H; lia].
      unfold apply. rewrite (sum_ext n _ (fun _ => 0)); [apply sum_zero|]. intros j J. rewrite Zero by exact J. ring.
    + destruct n as [|n]; [lia|].
      (* The unknown k, from the last equation. *)
      set (D := (fun i j => C i (beyond k j) - C i k * (C p (beyond k j) / C p k)) : matrix).
      destruct (IH n D) as (w & Positive & H); [lia|].
      set (s := sum n (fun j => C p (beyond k j) / C p k * w j)).
      set (v := (fun j => if Nat.eqb j k then - s else w (if Nat.ltb j k then j else j - 1)%nat) : vector).
      assert (At : v k = - s) by (unfold v; rewrite Nat.eqb_refl; reflexivity).
      assert (Beyond : forall j, v (beyond k j) = w j).
      { intros j. unfold v, beyond. destruct (Nat.ltb_spec j k) as [A|A].
        - destruct (Nat.eqb_spec j k); [lia|]. destruct (Nat.ltb_spec j k); [reflexivity|lia].
        - destruct (Nat.eqb_spec (S j) k); [lia|]. destruct (Nat.ltb_spec (S j) k); [lia|]. f_equal. lia. }
      exists v. split.
      * unfold square. rewrite (sum_without n k) by lia.
        rewrite (sum_ext n _ (fun j => w j * w j)) by (intros; rewrite Beyond; reflexivity).
        fold (square n w). assert (0 <= v k * v k) by apply Rle_0_sqr. lra.
      * assert (Rows : forall i, apply (S n) C v i = - s * C i k + sum n (fun j => C i (beyond k j) * w j)).
        { intros i. unfold apply. rewrite (sum_without n k), At by lia.
          rewrite (sum_ext n _ (fun j => C i (beyond k j) * w j)) by (intros; rewrite Beyond; reflexivity). ring. }
        assert (Last : apply (S n) C v p = 0).
        { rewrite Rows. rewrite (sum_ext n _ (fun j => C p k * (C p (beyond k j) / C p k * w j))).
          - rewrite sum_times. fold s. ring.
          - intros j _. field. exact N. }
        intros i I. destruct (Nat.eq_dec i p) as [->|E]; [exact Last|].
        rewrite Rows. specialize (H i ltac:(lia)). unfold apply, D in H.
        rewrite (sum_ext n _ (fun j => C i (beyond k j) * w j - C i k * (C p (beyond k j) / C p k * w j))) in H
          by (intros; ring).
        rewrite sum_minus, sum_times in H. fold s in H. lra.
Qed.

(** A positive definite matrix has an inverse: every equation [P x = b] has a solution. *)
Theorem positive_definite_solves n (P : matrix) q :
  0 < q -> (forall v, q * square n v <= form n P v) ->
  forall b : vector, exists x : vector, forall i, (i < n)%nat -> apply n P x i = b i.
Proof.
  intros Hq Positive b.
  destruct (nullspace n (S n) (fun i j => if Nat.eqb j n then - b i else P i j)) as (v & Nonzero & H); [lia|].
  assert (E : forall i, (i < n)%nat -> apply n P v i = v n * b i).
  { intros i I. specialize (H i I). unfold apply in *. simpl in H. rewrite Nat.eqb_refl in H.
    rewrite (sum_ext n _ (fun j => P i j * v j)) in H; [lra|].
    intros j J. destruct (Nat.eqb_spec j n); [lia|reflexivity]. }
  destruct (Req_dec (v n) 0) as [Z|Z].
  - exfalso. assert (F : form n P v = 0).
    { unfold form, bilinear. rewrite (sum_ext n _ (fun _ => 0)); [apply sum_zero|]. intros i I. rewrite E, Z by exact I.
      ring. }
    specialize (Positive v). rewrite F in Positive. unfold square in Nonzero. simpl in Nonzero. rewrite Z in Nonzero.
    fold (square n v) in Nonzero. pose proof (square_nonnegative n v).
    assert (0 < q * square n v) by (apply Rmult_lt_0_compat; lra). lra.
  - exists (fun j => / v n * v j). intros i I. rewrite apply_scale_vector, E by exact I. field. exact Z.
Qed.
