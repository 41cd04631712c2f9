(** Data between bounds: the theorem [linear-observer] for every A and C between two matrices each, entry by entry.

    [F'P + PF + 2 a P] is linear in [F = A - L C]. With the middle F0 of the bounds and [|F - F0| <= D] the form of what
    is added at v is at most [|v|'(D'|P| + |P|D)|v|], |v| entry by entry, and [|v_j||v_k| <= w_j w_k (u_j^2 +
      u_k^2)/2] for
    [v = w u] with any positive weights w. *)

From Coq Require Import Reals QArith Qreals ZArith List Lra Lia.
From Luenberger Require Import Vectors Definite Inequalities Decay LinearObserver.
Import ListNotations.
Local Open Scope R_scope.
Local Open Scope lazy_bool_scope.

(** [low <= M <= high], entry by entry. *)
Definition within (n m : nat) (low high : list (list Q)) (M : matrix) : Prop :=
  forall i j, (i < n)%nat -> (j < m)%nat -> real low i j <= M i j <= real high i j.

(** ** Middles, radii and absolute values *)

Definition middle (n m : nat) (low high : list (list Q)) : numbers :=
  multiple n m (1 # 2) (added n m (numbers_of n m low) (numbers_of n m high)).

Definition radius (n m : nat) (low high : list (list Q)) : numbers :=
  multiple n m (1 # 2) (subtracted n m (numbers_of n m high) (numbers_of n m low)).

Definition middle_matrix (low high : list (list Q)) : matrix := scale (/ 2) (plus (real low) (real high)).
Definition radius_matrix (low high : list (list Q)) : matrix := scale (/ 2) (minus (real high) (real low)).

Lemma half : Q2R (1 # 2) = / 2.
Proof. unfold Q2R. simpl. lra. Qed.

Lemma middle_correct n m low high :
  fits n m low = true -> fits n m high = true -> equals n m (middle n m low high) (middle_matrix low high).
Proof.
  intros L H. unfold middle_matrix. rewrite <- half.
  apply multiple_correct, added_correct; apply fits_equals; assumption.
Qed.

Lemma radius_correct n m low high :
  fits n m low = true -> fits n m high = true -> equals n m (radius n m low high) (radius_matrix low high).
Proof.
  intros L H. unfold radius_matrix. rewrite <- half.
  apply multiple_correct, subtracted_correct; apply fits_equals; assumption.
Qed.

Definition absolute (n m : nat) (X : numbers) : numbers := (table n m (fun i j => Z.abs (get (fst X) i j)), snd X).

Definition magnitude (M : matrix) : matrix := fun i j => Rabs (M i j).

Lemma absolute_correct n m X M : equals n m X M -> equals n m (absolute n m X) (magnitude M).
Proof.
  intros E i j I J. unfold value. cbn [fst snd absolute]. rewrite get_table by assumption. unfold magnitude.
  rewrite <- (E i j I J), abs_IZR. unfold value, Rdiv. rewrite Rabs_mult. f_equal. symmetry. apply Rabs_pos_eq.
  apply Rlt_le, Rinv_0_lt_compat, denominator_positive.
Qed.

Lemma within_near n m low high M i j :
  within n m low high M -> (i < n)%nat -> (j < m)%nat ->
  Rabs (M i j - middle_matrix low high i j) <= radius_matrix low high i j.
Proof.
  intros H I J. specialize (H i j I J). unfold middle_matrix, radius_matrix, scale, plus, minus. apply Rabs_le. lra.
Qed.

Lemma Rabs_sum n f : Rabs (sum n f) <= sum n (fun i => Rabs (f i)).
Proof.
  induction n as [|n IH]; simpl; [rewrite Rabs_R0; lra|]. apply Rle_trans with (1 := Rabs_triang _ _). lra.
Qed.

(** ** What deviations add *)

Section Deviation.
  Variables (n : nat) (P D E : matrix) (v : vector).
  Hypothesis Near : forall i j, (i < n)%nat -> (j < n)%nat -> Rabs (E i j) <= D i j.

  Let size : vector := fun i => Rabs (v i).

  Lemma deviation_applied i : (i < n)%nat -> Rabs (apply n E v i) <= apply n D size i.
  Proof.
    intros I. apply Rle_trans with (1 := Rabs_sum _ _), sum_le. intros j J. rewrite Rabs_mult.
    apply Rmult_le_compat_r; [apply Rabs_pos|apply Near; assumption].
  Qed.

  Lemma deviation_form :
    bilinear n n P (apply n E v) v + bilinear n n P v (apply n E v)
    <= form n (lyapunov_matrix n D (magnitude P) 0) size.
  Proof.
    rewrite lyapunov_form. rewrite Rmult_0_r, Rmult_0_l, Rplus_0_r.
    assert (Nonnegative : forall i, (i < n)%nat -> 0 <= apply n D size i).
    { intros i I. apply Rle_trans with (2 := deviation_applied i I), Rabs_pos. }
    apply Rplus_le_compat; unfold bilinear.
    - apply sum_le. intros i I. apply Rle_trans with (Rabs (apply n E v i) * Rabs (apply n P v i)).
      + rewrite <- Rabs_mult. apply Rle_abs.
      + apply Rmult_le_compat; try apply Rabs_pos; [apply deviation_applied, I|].
        apply Rle_trans with (1 := Rabs_sum _ _), Req_le, sum_ext. intros j _. apply Rabs_mult.
    - apply sum_le. intros i I. apply Rle_trans with (Rabs (v i) * Rabs (apply n P (apply n E v) i)).
      + rewrite <- Rabs_mult. apply Rle_abs.
      + apply Rmult_le_compat_l; [apply Rabs_pos|]. apply Rle_trans with (1 := Rabs_sum _ _), sum_le. intros j J.
        rewrite Rabs_mult. apply Rmult_le_compat_l; [apply Rabs_pos|apply deviation_applied, J].
  Qed.
End Deviation.

(** [w_i w_j G_ij] less [w_i sum_k (R_ik + R_ki) w_k / 2] on the diagonal, over twice the denominators. *)
Definition less_spread (n : nat) (w : list Z) (G R : numbers) : numbers :=
  let weight i := nth i w 0%Z in
  (table n n (fun i j =>
     2 * Zpos (snd R) * weight i * weight j * get (fst G) i j
     - (if Nat.eqb i j
        then Zpos (snd G) * weight i * zsum n (fun k => (Z.abs (get (fst R) i k) + Z.abs (get (fst R) k i)) * weight k)
        else 0))%Z, (2 * (snd G * snd R))%positive).

Lemma below_products x y a b : 0 < a -> 0 < b -> x * y <= (b / a * (x * x) + a / b * (y * y)) / 2.
Proof.
  intros A B. set (u := x / a). set (v := y / b).
  replace x with (a * u) by (unfold u; field; lra). replace y with (b * v) by (unfold v; field; lra).
  replace ((b / a * (a * u * (a * u)) + a / b * (b * v * (b * v))) / 2) with (a * b * ((u * u + v * v) / 2)) by
    (field; lra).
  replace (a * u * (b * v)) with (a * b * (u * v)) by ring.
  apply Rmult_le_compat_l; [apply Rmult_le_pos; lra|]. assert (0 <= (u - v) * (u - v)) by apply Rle_0_sqr. lra.
Qed.

Lemma less_spread_correct n w X G Y R v :
  all n (fun i => 0 <? nth i w 0)%Z = true -> equals n n X G -> equals n n Y R ->
  semidefinite n (less_spread n w X Y) = true ->
  form n R (fun i => Rabs (v i)) <= form n G v.
Proof.
  intros W EX EY H. set (a := fun i => IZR (nth i w 0%Z)).
  assert (A : forall i, (i < n)%nat -> 0 < a i).
  { intros i I. apply (all_correct _ _ i) in W; [|exact I]. apply Z.ltb_lt, IZR_lt in W. exact W. }
  pose proof (denominator_positive X) as DX. pose proof (denominator_positive Y) as DY.
  set (s := fun i => sum n (fun k => (Rabs (R i k) + Rabs (R k i)) * a k)).
  assert (E : equals n n (less_spread n w X Y)
    (fun i j => a i * a j * G i j - identity i j * (a i * s i / 2))).
  { intros i j I J. unfold value, less_spread. cbn [fst snd]. rewrite get_table by assumption. rewrite <- (EX i j I J).
    unfold value. rewrite minus_IZR, !mult_IZR. unfold identity.
    replace (IZR (Zpos (2 * (snd X * snd Y)))) with (2 * (IZR (Zpos (snd X)) * IZR (Zpos (snd Y)))).
    2: { rewrite !Pos2Z.inj_mul, !mult_IZR. reflexivity. }
    destruct (Nat.eqb_spec i j) as [<-|N].
    - rewrite !mult_IZR, IZR_zsum.
      rewrite (sum_ext n (fun k => IZR ((Z.abs (get (fst Y) i k) + Z.abs (get (fst Y) k i)) * nth k w 0%Z))
        (fun k => IZR (Zpos (snd Y)) * ((Rabs (R i k) + Rabs (R k i)) * a k))).
      + rewrite sum_times. fold (s i). unfold a. field. split; lra.
      + intros k K. rewrite mult_IZR, plus_IZR, !abs_IZR. fold (a k).
        rewrite <- (EY i k I K), <- (EY k i K I). unfold value, Rdiv. rewrite !Rabs_mult.
        rewrite (Rabs_pos_eq (/ IZR (Zpos (snd Y)))) by (apply Rlt_le, Rinv_0_lt_compat, DY). field. lra.
    - unfold a. field. split; lra. }
  pose proof (semidefinite_correct _ _ _ E H (fun i => v i / a i)) as K.
  assert (F : form n (fun i j => a i * a j * G i j - identity i j * (a i * s i / 2)) (fun i => v i / a i)
    = form n G v - sum n (fun i => s i / a i / 2 * (v i * v i))).
  { unfold form, bilinear, apply. rewrite <- sum_minus. apply sum_ext. intros i I. specialize (A i I).
    rewrite (sum_ext n _ (fun j => a i * (G i j * v j) - identity i j * (a i * s i / 2 * (v j / a j)))).
    - rewrite sum_minus, sum_times, (sum_delta n (fun j => a i * s i / 2 * (v j / a j))) by exact I. field. lra.
    - intros j J. pose proof (A) as Ai. assert (0 < a j) by (apply IZR_lt; apply (all_correct _ _ j) in W; [|exact J];
        apply Z.ltb_lt, W). field. lra. }
  rewrite F in K. apply Rle_trans with (sum n (fun i => s i / a i / 2 * (v i * v i))); [|lra].
  (* |v|'R|v| <= sum of R_ij (a_j/a_i v_i^2 + a_i/a_j v_j^2)/2 *)
  apply Rle_trans with (sum n (fun i => sum n (fun j => Rabs (R i j) * ((a j / a i * (v i * v i) + a i / a j * (v j *
    v j))
    / 2)))).
  { unfold form, bilinear, apply. apply sum_le. intros i I. rewrite <- sum_times. apply sum_le. intros j J.
    apply Rle_trans with (Rabs (R i j) * (Rabs (v i) * Rabs (v j))).
    - replace (Rabs (v i) * (R i j * Rabs (v j))) with (R i j * (Rabs (v i) * Rabs (v j))) by ring.
      apply Rmult_le_compat_r; [apply Rmult_le_pos; apply Rabs_pos|apply Rle_abs].
    - apply Rmult_le_compat_l; [apply Rabs_pos|].
      pose proof (below_products (Rabs (v i)) (Rabs (v j)) (a i) (a j) (A i I) (A j J)) as B.
      rewrite <- !Rabs_mult in B. rewrite (Rabs_pos_eq (v i * v i)), (Rabs_pos_eq (v j * v j)) in B by apply Rle_0_sqr.
      rewrite <- Rabs_mult. exact B. }
  apply Req_le.
  transitivity (sum n (fun i => sum n (fun j => Rabs (R i j) * (a j / a i * (v i * v i)) / 2))
    + sum n (fun i => sum n (fun j => Rabs (R j i) * (a j / a i * (v i * v i)) / 2))).
  - rewrite (sum_exchange n n (fun i j => Rabs (R j i) * (a j / a i * (v i * v i)) / 2)), <- sum_plus. apply sum_ext.
    intros i _. rewrite <- sum_plus. apply sum_ext. intros j _. lra.
  - rewrite <- sum_plus. apply sum_ext. intros i I. specialize (A i I). unfold s. rewrite <- sum_plus.
    replace (sum n (fun k => (Rabs (R i k) + Rabs (R k i)) * a k) / a i / 2 * (v i * v i))
      with (sum n (fun k => (Rabs (R i k) + Rabs (R k i)) * a k) * (v i * v i / a i / 2)) by (field; lra).
    rewrite <- sum_times_right. apply sum_ext. intros j _. field. lra.
Qed.

(** ** The inequality for all data between the bounds *)

(** [|F - F0| <= DA + |L| DC] *)
Definition deviation_numbers (n p : nat) (A_low A_high C_low C_high L : list (list Q)) : numbers :=
  shortened n n
    (added n n (radius n n A_low A_high) (times n p n (absolute n p (numbers_of n p L)) (radius p n C_low C_high))).

Definition deviation (p : nat) (A_low A_high C_low C_high L : list (list Q)) : matrix :=
  plus (radius_matrix A_low A_high) (product p (magnitude (real L)) (radius_matrix C_low C_high)).

Definition middle_error (n p : nat) (A_low A_high C_low C_high L : list (list Q)) : numbers :=
  shortened n n (subtracted n n (middle n n A_low A_high) (times n p n (numbers_of n p L) (middle p n C_low C_high))).

Definition falls_within (n p : nat) (A_low A_high C_low C_high L P : list (list Q)) (rate q : Q) : bool :=
  fits n n A_low &&& fits n n A_high &&& fits p n C_low &&& fits p n C_high &&& fits n p L &&& fits n n P
    &&& (let G := subtracted n n (negative n n (lyapunov_numbers n (middle_error n p A_low A_high C_low C_high L)
                    (numbers_of n n P) rate)) (multiple_of_identity n q) in
         let R := lyapunov_numbers n (deviation_numbers n p A_low A_high C_low C_high L) (absolute n n (numbers_of n n
           P)) 0 in
         (* Scaled by what is left of the diagonal. *)
         let w := fst (weights n (table n n (fun i j =>
           get (fst G) i j * Zpos (snd R) - Z.abs (get (fst R) i j) * Zpos (snd G))%Z)) in
         all n (fun i => 0 <? nth i w 0)%Z &&& semidefinite n (less_spread n w G R)).

Lemma middle_error_correct n p A_low A_high C_low C_high L :
  fits n n A_low = true -> fits n n A_high = true -> fits p n C_low = true -> fits p n C_high = true ->
  fits n p L = true ->
  equals n n (middle_error n p A_low A_high C_low C_high L)
    (minus (middle_matrix A_low A_high) (product p (real L) (middle_matrix C_low C_high))).
Proof.
  intros FAl FAh FCl FCh FL. apply shortened_correct, subtracted_correct; [apply middle_correct; assumption|].
  apply times_correct; [apply fits_equals, FL|]. apply middle_correct; assumption.
Qed.

Lemma deviation_correct n p A_low A_high C_low C_high L :
  fits n n A_low = true -> fits n n A_high = true -> fits p n C_low = true -> fits p n C_high = true ->
  fits n p L = true ->
  equals n n (deviation_numbers n p A_low A_high C_low C_high L) (deviation p A_low A_high C_low C_high L).
Proof.
  intros FAl FAh FCl FCh FL. apply shortened_correct, added_correct; [apply radius_correct; assumption|].
  apply times_correct; [apply absolute_correct, fits_equals, FL|]. apply radius_correct; assumption.
Qed.

Lemma deviation_near n p A_low A_high C_low C_high L (A C : matrix) :
  within n n A_low A_high A -> within p n C_low C_high C ->
  let F0 := minus (middle_matrix A_low A_high) (product p (real L) (middle_matrix C_low C_high)) in
  forall i j, (i < n)%nat -> (j < n)%nat ->
  Rabs (minus A (product p (real L) C) i j - F0 i j) <= deviation p A_low A_high C_low C_high L i j.
Proof.
  intros HA HC F0 i j I J. unfold F0, deviation, minus, plus, product.
  replace (A i j - sum p (fun l => real L i l * C l j) - (middle_matrix A_low A_high i j
    - sum p (fun l => real L i l * middle_matrix C_low C_high l j)))
    with ((A i j - middle_matrix A_low A_high i j)
      + - sum p (fun l => real L i l * (C l j - middle_matrix C_low C_high l j))).
  2: { rewrite (sum_ext p (fun l => real L i l * (C l j - middle_matrix C_low C_high l j))
    (fun l => real L i l * C l j - real L i l * middle_matrix C_low C_high l j)) by (intros; ring).
    rewrite sum_minus. ring. }
  apply Rle_trans with (1 := Rabs_triang _ _). apply Rplus_le_compat; [apply within_near with (1 := HA); assumption|].
  rewrite Rabs_Ropp. apply Rle_trans with (1 := Rabs_sum _ _), sum_le. intros l L'. rewrite Rabs_mult.
  apply Rmult_le_compat_l; [apply Rabs_pos|apply within_near with (1 := HC); assumption].
Qed.

Theorem falls_within_form n p A_low A_high C_low C_high L P rate q :
  falls_within n p A_low A_high C_low C_high L P rate q = true ->
  forall A C : matrix, within n n A_low A_high A -> within p n C_low C_high C ->
  forall v, form n (lyapunov_matrix n (minus A (product p (real L) C)) (real P) (Q2R rate)) v <= - Q2R q * square n v.
Proof.
  intros H A C HA HC v. apply both in H. destruct H as [H K]. apply both in H. destruct H as [H FP]. apply both in H.
  destruct H as [H FL]. apply both in H. destruct H as [H FCh]. apply both in H. destruct H as [H FCl]. apply both in H.
  destruct H as [FAl FAh]. cbv zeta in K. apply both in K. destruct K as [W K].
  set (F0 := minus (middle_matrix A_low A_high) (product p (real L) (middle_matrix C_low C_high))).
  set (E := fun i j => minus A (product p (real L) C) i j - F0 i j).
  set (D := deviation p A_low A_high C_low C_high L).
  assert (EF : equals n n (middle_error n p A_low A_high C_low C_high L) F0)
    by (apply middle_error_correct; assumption).
  assert (ED : equals n n (deviation_numbers n p A_low A_high C_low C_high L) D)
    by (apply deviation_correct; assumption).
  assert (Near : forall i j, (i < n)%nat -> (j < n)%nat -> Rabs (E i j) <= D i j)
    by (apply deviation_near; assumption).
  pose proof (less_spread_correct n _ _ _ _ _ v W
    (subtracted_correct _ _ _ _ _ _ (negative_correct _ _ _ _ (lyapunov_numbers_correct n _ _ rate _ _ EF
      (fits_equals _ _ _ FP))) (multiple_of_identity_correct n q))
    (lyapunov_numbers_correct n _ _ 0 _ _ ED (absolute_correct _ _ _ _ (fits_equals _ _ _ FP))) K) as G.
  rewrite Q2R_zero in G. pose proof (deviation_form n (real P) D E v Near) as S.
  unfold form in G at 2. rewrite bilinear_minus, !bilinear_scale in G.
  fold (form n identity v) (form n (lyapunov_matrix n F0 (real P) (Q2R rate)) v) in G. rewrite form_identity in G.
  rewrite (lyapunov_form n F0) in G. rewrite lyapunov_form.
  assert (Flow : forall i, apply n (minus A (product p (real L) C)) v i = apply n F0 v i + apply n E v i).
  { intros i. rewrite <- apply_plus. apply apply_ext; [|reflexivity]. intros j _. unfold E, plus. ring. }
  rewrite (bilinear_ext n n (real P) (real P) (apply n (minus A (product p (real L) C)) v) v
    (fun i => apply n F0 v i + apply n E v i) v) by (try (intros; apply Flow); easy).
  rewrite (bilinear_ext n n (real P) (real P) v (apply n (minus A (product p (real L) C)) v) v
    (fun i => apply n F0 v i + apply n E v i)) by (try (intros; apply Flow); easy).
  rewrite (bilinear_plus_left n n), (bilinear_plus_right n n).
  change (fun i => apply n E v i) with (apply n E v) in *. lra.
Qed.

(** [F v] in a form. *)
Lemma within_apply n p (A C : matrix) L (v : vector) i :
  has_shape n p L = true -> (i < n)%nat ->
  (apply n A v - L * apply n C v)%vector i = apply n (minus A (product p (real L) C)) v i.
Proof.
  intros HL I. unfold minus_vector. rewrite apply_minus, apply_product, (times_vector_apply n p L) by assumption.
  reflexivity.
Qed.

Lemma falls_within_shapes n p A_low A_high C_low C_high L P rate q :
  falls_within n p A_low A_high C_low C_high L P rate q = true -> has_shape n p L = true /\ has_shape n n P = true.
Proof.
  intros H. apply both in H. destruct H as [H _]. apply both in H. destruct H as [H FP]. apply both in H.
  destruct H as [_ FL]. split; eapply fits_shape; eassumption.
Qed.

(** The fact (12) of certificates, for all data between the bounds, with its margin q. *)
Theorem lyapunov_inequality_within n p A_low A_high C_low C_high L P rate q :
  is_positive q &&& falls_within n p A_low A_high C_low C_high L P rate q = true ->
  0 < Q2R q /\ forall A C : matrix, within n n A_low A_high A -> within p n C_low C_high C ->
  forall v : vector, let w := (apply n A v - L * apply n C v)%vector in
  inner n w (P * v)%vector + inner n v (P * w)%vector + 2 * Q2R rate * quadratic n P v <= - Q2R q * square n v.
Proof.
  intros H. apply both in H. destruct H as [Positive H]. split; [apply is_positive_correct, Positive|].
  intros A C HA HC v w. destruct (falls_within_shapes _ _ _ _ _ _ _ _ _ _ H) as [HL HP].
  pose proof (falls_within_form _ _ _ _ _ _ _ _ _ _ H A C HA HC v) as K. rewrite lyapunov_form in K.
  rewrite !inner_bilinear, quadratic_form by exact HP.
  assert (E : forall i, (i < n)%nat -> w i = apply n (minus A (product p (real L) C)) v i).
  { intros i I. apply within_apply; assumption. }
  rewrite (bilinear_ext n n (real P) (real P) w v _ v (fun i j _ _ => eq_refl) E (fun i _ => eq_refl)).
  rewrite (bilinear_ext n n (real P) (real P) v w v _ (fun i j _ _ => eq_refl) (fun i _ => eq_refl) E). exact K.
Qed.

(** ** The statement about trajectories *)

(** [low <= high], so that there is something between. *)
Definition are_ordered (n m : nat) (low high : list (list Q)) : bool :=
  all n (fun i => all m (fun j => Qle_bool (entry low i j) (entry high i j))).

Definition decays_within (n p : nat) (A_low A_high C_low C_high L P : list (list Q)) (a lower upper overshoot : Q) :
  bool :=
  is_between n P lower upper overshoot &&& are_ordered n n A_low A_high &&& are_ordered p n C_low C_high
    &&& falls_within n p A_low A_high C_low C_high L P a 0.

Section Error.
  Variables (n p : nat) (A_low A_high C_low C_high L P : list (list Q)) (a lower upper overshoot : Q).
  Hypothesis Checked : decays_within n p A_low A_high C_low C_high L P a lower upper overshoot = true.

  (** Every solution of [e' = (A(t) - L C(t))e] with A(t) and C(t) between the bounds. *)
  Theorem within_error_decays (T : R) (e : R -> vector) (A C : R -> matrix) :
    (forall t, within n n A_low A_high (A t)) -> (forall t, within p n C_low C_high (C t)) ->
    solution T n e (fun t => apply n (A t) (e t) - L * apply n (C t) (e t))%vector ->
    (forall s t, 0 <= s -> s <= t -> t < T ->
      quadratic n P (e t) <= exp (- (2 * Q2R a) * (t - s)) * quadratic n P (e s))
    /\ (forall t, 0 <= t -> t < T -> norm n (e t) <= Q2R overshoot * exp (- Q2R a * t) * norm n (e 0)).
  Proof.
    intros HA HC E. pose proof (both _ _ Checked) as [H Falls]. apply both in H. destruct H as [H _]. apply both in H.
    destruct H as [Between _]. destruct (falls_within_shapes _ _ _ _ _ _ _ _ _ _ Falls) as [HL HP].
    set (f := fun t => apply n (minus (A t) (product p (real L) (C t))) (e t)).
    assert (S : solution T n e f).
    { apply (solution_ext T n e (fun t => apply n (A t) (e t) - L * apply n (C t) (e t))%vector); [|exact E].
      intros t i I. apply within_apply; assumption. }
    assert (K : forall s t, 0 <= s -> s <= t -> t < T ->
      quadratic n P (e t) <= exp (- (2 * Q2R a) * (t - s)) * quadratic n P (e s)).
    { intros s t Hs Hst Ht. rewrite !quadratic_form by exact HP.
      apply (lyapunov_decay n (real P) (Q2R a) T e f S); try assumption. intros r _.
      pose proof (falls_within_form _ _ _ _ _ _ _ _ _ _ Falls (A r) (C r) (HA r) (HC r) (e r)) as D.
      rewrite lyapunov_form, Q2R_zero in D. unfold f. lra. }
    split; [exact K|]. intros t Hs Ht.
    apply (norm_of_form n P lower upper overshoot Between); [apply Rlt_le, exp_pos|].
    specialize (K 0 t (Rle_refl 0) Hs Ht). rewrite !quadratic_form, Rminus_0_r in K by exact HP.
    replace (exp (- Q2R a * t) * exp (- Q2R a * t)) with (exp (- (2 * Q2R a) * t)); [exact K|].
    rewrite <- exp_plus. f_equal. ring.
  Qed.

  (** The error of plant and observer, for every A and C between the bounds, every B and every input. *)
  Theorem within_observer_decays (m : nat) (A B C : matrix) (T : R) (u x xhat : R -> vector) :
    within n n A_low A_high A -> within p n C_low C_high C ->
    solution T n x (fun t => apply n A (x t) + apply m B (u t))%vector ->
    solution T n xhat (fun t => apply n A (xhat t) + apply m B (u t) + L * (apply n C (x t) - apply n C (xhat
      t)))%vector ->
    let e t := (x t - xhat t)%vector in
    (forall s t, 0 <= s -> s <= t -> t < T ->
      quadratic n P (e t) <= exp (- (2 * Q2R a) * (t - s)) * quadratic n P (e s))
    /\ (forall t, 0 <= t -> t < T -> norm n (e t) <= Q2R overshoot * exp (- Q2R a * t) * norm n (e 0)).
  Proof.
    intros HA HC Plant Observer e. apply (within_error_decays T e (fun _ => A) (fun _ => C)); try (intros; assumption).
    pose proof (both _ _ Checked) as [_ Falls]. destruct (falls_within_shapes _ _ _ _ _ _ _ _ _ _ Falls) as [HL HP].
    refine (solution_ext T n e (fun t i => (apply n A (x t) + apply m B (u t))%vector i - _ t i) _ _
      (solution_difference T n x xhat _ _ Plant Observer)).
    intros t i I. cbv beta. unfold plus_vector, minus_vector. rewrite !(times_vector_apply n p L) by assumption.
    rewrite (apply_ext p (real L) (real L) (apply n C (e t)) (fun j => apply n C (x t) j - apply n C (xhat t) j) i).
    - unfold e, minus_vector. rewrite (apply_minus_vector n A (x t) (xhat t)). ring.
    - reflexivity.
    - intros j _. apply apply_minus_vector.
  Qed.
End Error.
