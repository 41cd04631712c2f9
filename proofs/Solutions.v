(** Solutions for all times of [e' = g(e)] where a function V falls: [g] is a polynomial, or locally Lipschitz, and
    [V = e'Pe] with P > 0 does not grow along it below a level.

    The entries of e are kept between two bounds, which changes nothing below the level. The right side is bounded and
    Lipschitz then, and the successive approximations [u(k+1)' = g(u(k))] converge (Picard): their differences fall like
    [2^-k exp(2 K t)] with the constant K of Lipschitz. Along the solution V stays below the level ([stays_below]), so
    that it is one of the right side as it was. *)

From Coq Require Import Reals List Lra Lia PSeries_reg Ranalysis5.
From Luenberger Require Import Vectors Decay CubicRegion.
Import ListNotations.
Local Open Scope R_scope.

(** ** Integrals *)

Section Integral.
  Variable f : R -> R.
  Hypothesis Continuous : continuity f.

  Lemma cover s : - (Rabs s + 1) <= Rabs s + 1.
  Proof. pose proof (Rabs_pos s). lra. Qed.

  (** An antiderivative on an interval around 0 and s. *)
  Definition piece (s : R) : R -> R :=
    proj1_sig (@RiemannInt_P30 f (- (Rabs s + 1)) (Rabs s + 1) (cover s) (fun x _ => Continuous x)).

  Lemma piece_derivative s x : Rabs x <= Rabs s + 1 -> derivable_pt_lim (piece s) x (f x).
  Proof.
    intros H. assert (A : antiderivative f (piece s) (- (Rabs s + 1)) (Rabs s + 1)) by apply (proj2_sig
      (RiemannInt_P30 (cover s) (fun x _ => Continuous x))).
    destruct A as [D _]. destruct (D x) as (pr & E).
    - pose proof (Rle_abs x). pose proof (Rle_abs (- x)). rewrite Rabs_Ropp in *. lra.
    - apply derive_pt_eq_1 with pr. symmetry. exact E.
  Qed.

  Lemma pieces_agree s r x :
    Rabs x <= Rabs s + 1 -> Rabs x <= Rabs r + 1 -> piece s x - piece s 0 = piece r x - piece r 0.
  Proof.
    intros S R'. set (h := fun z => piece s z - piece r z).
    assert (D : forall z, Rabs z <= Rabs x -> derivable_pt_lim h z 0).
    { intros z Z. replace 0 with (f z - f z) by ring.
      apply (derivable_pt_lim_minus (piece s) (piece r)); apply piece_derivative; lra. }
    assert (E : h x = h 0); [|unfold h in E; lra].
    destruct (Rtotal_order x 0) as [L|[->|G]]; [|reflexivity|].
    - destruct (MVT_cor2 h (fun _ => 0) x 0 L) as (c & K & _); [|lra].
      intros c Hc. apply D. rewrite (Rabs_left x), Rabs_left1; lra.
    - destruct (MVT_cor2 h (fun _ => 0) 0 x G) as (c & K & _); [|lra].
      intros c Hc. apply D. rewrite !Rabs_pos_eq; lra.
  Qed.

  (** The integral of f from 0 to t. *)
  Definition integral (t : R) : R := piece t t - piece t 0.

  Lemma integral_start : integral 0 = 0.
  Proof. unfold integral. ring. Qed.

  Lemma integral_derivative x : derivable_pt_lim integral x (f x).
  Proof.
    apply (derivable_pt_lim_locally_ext (fun z => piece x z - piece x 0) integral x (x - 1) (x + 1)); [lra| |].
    - intros z Z. symmetry. apply pieces_agree; [pose proof (Rabs_pos z); lra|].
      replace z with (x + (z - x)) by ring. apply Rle_trans with (1 := Rabs_triang _ _).
      assert (Rabs (z - x) <= 1) by (apply Rabs_le; lra). lra.
    - replace (f x) with (f x - 0) by ring. apply (derivable_pt_lim_minus (piece x) (fun _ => piece x 0)).
      + apply piece_derivative. lra.
      + apply derivable_pt_lim_const.
  Qed.

  Lemma integral_continuous : continuity integral.
  Proof. intros x. apply derivable_continuous_pt. exists (f x). apply integral_derivative. Qed.
End Integral.

(** What bounds the derivative bounds the function. *)
Lemma bounded_by_derivative G h B d :
  (forall t, derivable_pt_lim G t (h t)) -> (forall t, derivable_pt_lim B t (d t)) -> G 0 = 0 -> 0 <= B 0 ->
  (forall t, 0 <= t -> Rabs (h t) <= d t) -> forall t, 0 <= t -> Rabs (G t) <= B t.
Proof.
  intros DG DB Start Positive Bound t Ht.
  assert (One : forall s H, (forall t, derivable_pt_lim s t (H t)) -> s 0 = 0 -> (forall t, 0 <= t -> H t <= d t) ->
    s t <= B t).
  { intros s H D S L. assert (K : s t - B t <= s 0 - B 0); [|lra].
    apply (decreasing (t + 1) (fun t => s t - B t) (fun t => H t - d t)); try lra.
    - apply (right_continuous_minus s B); eapply right_continuous_derivable; [apply D|apply DB].
    - intros r _. apply (derivable_pt_lim_minus s B); [apply D|apply DB].
    - intros r Hr. specialize (L r ltac:(lra)). lra. }
  apply Rabs_le. split.
  - assert (K : - G t <= B t); [|lra]. apply (One (fun t => - G t) (fun t => - h t)).
    + intros r. apply (derivable_pt_lim_opp G). apply DG.
    + lra.
    + intros r Hr. specialize (Bound r Hr). pose proof (Rle_abs (- h r)). rewrite Rabs_Ropp in *. lra.
  - apply (One G h); [apply DG|exact Start|]. intros r Hr. specialize (Bound r Hr). pose proof (Rle_abs (h r)). lra.
Qed.

(** A limit is as near as the members of the sequence from one on. *)
Lemma limit_is_near (v : nat -> R) l k a b :
  Un_cv v l -> (forall m, Rabs (v (k + m)%nat - a) <= b) -> Rabs (l - a) <= b.
Proof.
  intros L H. apply Rnot_lt_le. intros A. destruct (L (Rabs (l - a) - b)) as (N & K); [lra|].
  specialize (K (k + N)%nat ltac:(lia)). specialize (H N). unfold R_dist in K. rewrite Rabs_minus_sym in K.
  assert (Rabs (l - a) <= Rabs (l - v (k + N)%nat) + Rabs (v (k + N)%nat - a)); [|lra].
  replace (l - a) with (l - v (k + N)%nat + (v (k + N)%nat - a)) by ring. apply Rabs_triang.
Qed.

(** ** Successive approximations *)

Section Picard.
  Variables (n : nat) (g : vector -> vector) (B K : R) (e0 : vector).
  Hypothesis Constant : 1 <= K.
  Hypothesis Size : 0 <= B.
  Hypothesis Bounded : forall x i, (i < n)%nat -> Rabs (g x i) <= B.
  Hypothesis Lipschitz : forall x y d, 0 <= d -> (forall i, (i < n)%nat -> Rabs (x i - y i) <= d) ->
    forall i, (i < n)%nat -> Rabs (g x i - g y i) <= K * d.

  Definition flow (x : vector) : vector := fun i => if Nat.ltb i n then g x i else 0.

  Lemma flow_bounded x i : Rabs (flow x i) <= B.
  Proof. unfold flow. destruct (Nat.ltb_spec i n); [apply Bounded; assumption|]. rewrite Rabs_R0. exact Size. Qed.

  Lemma flow_lipschitz x y d i :
    0 <= d -> (forall j, Rabs (x j - y j) <= d) -> Rabs (flow x i - flow y i) <= K * d.
  Proof.
    intros D H. unfold flow. destruct (Nat.ltb_spec i n); [apply Lipschitz; try assumption; intros; apply H|].
    rewrite Rminus_diag_eq, Rabs_R0 by reflexivity. apply Rmult_le_pos; lra.
  Qed.

  (** Curves of which every entry is continuous. *)
  Definition curve : Type := { e : R -> vector | forall i, continuity (fun t => e t i) }.

  Lemma near_all_entries (e : R -> vector) t m :
    (forall i, continuity (fun s => e s i)) -> forall eps, 0 < eps ->
    exists delta, 0 < delta /\ forall s, Rabs (s - t) < delta -> forall i, (i < m)%nat -> Rabs (e s i - e t i) <= eps.
  Proof.
    intros C eps He. induction m as [|m (d & Hd & H)].
    - exists 1. split; [lra|]. intros; lia.
    - destruct (C m t eps He) as (d' & Hd' & H'). exists (Rmin d d'). split; [apply Rmin_glb_lt; assumption|].
      intros s S i L. pose proof (Rmin_l d d'). pose proof (Rmin_r d d').
      destruct (Nat.eq_dec i m) as [->|N]; [|apply H; [lra|lia]].
      destruct (Req_dec s t) as [->|E]; [rewrite Rminus_diag_eq, Rabs_R0; [lra|reflexivity]|].
      apply Rlt_le. apply (H' s). split; [split; [exact I|congruence]|]. simpl. unfold R_dist. lra.
  Qed.

  Lemma flow_continuous (e : curve) i : continuity (fun t => flow (proj1_sig e t) i).
  Proof.
    destruct e as [e C]. simpl. intros t eps He.
    destruct (near_all_entries e t n C (eps / 2 / K)) as (d & Hd & H).
    { apply Rdiv_lt_0_compat; lra. }
    exists d. split; [exact Hd|]. intros s [_ S]. simpl in *. unfold R_dist in *. unfold flow.
    destruct (Nat.ltb_spec i n) as [L|L]; [|rewrite Rminus_diag_eq, Rabs_R0; trivial].
    apply Rle_lt_trans with (K * (eps / 2 / K)).
    - apply Lipschitz; [apply Rlt_le, Rdiv_lt_0_compat; lra|apply H, S|exact L].
    - replace (K * (eps / 2 / K)) with (eps / 2) by (field; lra). lra.
  Qed.

  Definition next_curve (e : curve) : R -> vector :=
    fun t i => e0 i + integral (fun s => flow (proj1_sig e s) i) (flow_continuous e i) t.

  Lemma next_derivative e t i : derivable_pt_lim (fun s => next_curve e s i) t (flow (proj1_sig e t) i).
  Proof.
    replace (flow (proj1_sig e t) i) with (0 + flow (proj1_sig e t) i) by ring. unfold next_curve.
    apply (derivable_pt_lim_plus (fun _ => e0 i)); [apply derivable_pt_lim_const|].
    apply (integral_derivative (fun s => flow (proj1_sig e s) i)).
  Qed.

  Lemma next_continuous e i : continuity (fun t => next_curve e t i).
  Proof. intros t. apply derivable_continuous_pt. eexists. apply next_derivative. Qed.

  Definition next (e : curve) : curve := exist _ (next_curve e) (next_continuous e).

  Lemma constant_continuous i : continuity (fun _ : R => e0 i).
  Proof. intros t. apply continuity_pt_const. intros a b. reflexivity. Qed.

  Fixpoint iterate (k : nat) : curve :=
    match k with O => exist _ (fun _ => e0) constant_continuous | S l => next (iterate l) end.

  Definition approximation (k : nat) : R -> vector := proj1_sig (iterate k).

  Lemma approximation_derivative k t i :
    derivable_pt_lim (fun s => approximation (S k) s i) t (flow (approximation k t) i).
  Proof. apply next_derivative. Qed.

  Lemma approximation_start k i : approximation k 0 i = e0 i.
  Proof.
    destruct k as [|k]; [reflexivity|]. unfold approximation. simpl. unfold next_curve. rewrite integral_start. ring.
  Qed.

  Lemma exp_derivative c t : derivable_pt_lim (fun s => c * exp (2 * K * s)) t (2 * K * (c * exp (2 * K * t))).
  Proof.
    replace (2 * K * (c * exp (2 * K * t))) with (c * (2 * K * exp (2 * K * t))) by ring.
    apply (derivable_pt_lim_scal (fun s => exp (2 * K * s))). apply derivative_exponential.
  Qed.

  Lemma step k t i : 0 <= t ->
    Rabs (approximation (S k) t i - approximation k t i) <= B * (/ 2) ^ k * exp (2 * K * t).
  Proof.
    revert t i. induction k as [|k IH]; intros t i Ht.
    - apply (bounded_by_derivative (fun t => approximation 1 t i - e0 i) (fun t => flow (approximation 0 t) i - 0)
        (fun t => B * (/ 2) ^ 0 * exp (2 * K * t)) (fun t => 2 * K * (B * (/ 2) ^ 0 * exp (2 * K * t))));
          try assumption.
      + intros s. apply (derivable_pt_lim_minus (fun s => approximation 1 s i) (fun _ => e0 i));
          [apply approximation_derivative|apply derivable_pt_lim_const].
      + intros s. apply exp_derivative.
      + rewrite approximation_start. ring.
      + simpl. apply Rmult_le_pos; [lra|apply Rlt_le, exp_pos].
      + intros s Hs. rewrite Rminus_0_r. apply Rle_trans with (1 := flow_bounded _ _). simpl. rewrite Rmult_1_r.
        assert (1 <= exp (2 * K * s)).
        { rewrite <- exp_0. assert (Z : 0 <= 2 * K * s) by (apply Rmult_le_pos; lra).
          destruct Z as [Z|<-]; [apply Rlt_le, exp_increasing, Z|lra]. }
        assert (B * 1 <= B * exp (2 * K * s)) by (apply Rmult_le_compat_l; lra).
        assert (1 * (B * exp (2 * K * s)) <= 2 * K * (B * exp (2 * K * s))); [|lra].
        apply Rmult_le_compat_r; lra.
    - apply (bounded_by_derivative (fun t => approximation (S (S k)) t i - approximation (S k) t i)
        (fun t => flow (approximation (S k) t) i - flow (approximation k t) i)
        (fun t => B * (/ 2) ^ S k * exp (2 * K * t)) (fun t => 2 * K * (B * (/ 2) ^ S k * exp (2 * K * t))));
        try assumption.
      + intros s. apply (derivable_pt_lim_minus (fun s => approximation (S (S k)) s i) (fun s => approximation (S k) s
        i));
          apply approximation_derivative.
      + intros s. apply exp_derivative.
      + rewrite !approximation_start. ring.
      + apply Rmult_le_pos; [apply Rmult_le_pos; [exact Size|apply pow_le; lra]|apply Rlt_le, exp_pos].
      + intros s Hs. replace (2 * K * (B * (/ 2) ^ S k * exp (2 * K * s))) with (K * (B * (/ 2) ^ k * exp (2 * K * s)))
          by (simpl; field).
        apply flow_lipschitz.
        * apply Rmult_le_pos; [apply Rmult_le_pos; [exact Size|apply pow_le; lra]|apply Rlt_le, exp_pos].
        * intros j. apply IH, Hs.
  Qed.

  Lemma tail k m t i : 0 <= t ->
    Rabs (approximation (k + m) t i - approximation k t i) <= 2 * B * (/ 2) ^ k * exp (2 * K * t).
  Proof.
    intros Ht. assert (P : 0 <= 2 * B * (/ 2) ^ k * exp (2 * K * t)).
    { apply Rmult_le_pos; [apply Rmult_le_pos; [lra|apply pow_le; lra]|apply Rlt_le, exp_pos]. }
    apply Rle_trans with (2 * B * (/ 2) ^ k * exp (2 * K * t) * (1 - (/ 2) ^ m)).
    - induction m as [|m IH].
      + rewrite Nat.add_0_r, Rminus_diag_eq, Rabs_R0 by reflexivity. simpl. lra.
      + rewrite Nat.add_succ_r. pose proof (step (k + m) t i Ht) as Next. rewrite pow_add in Next.
        replace (approximation (S (k + m)) t i - approximation k t i)
          with (approximation (S (k + m)) t i - approximation (k + m) t i
                + (approximation (k + m) t i - approximation k t i)) by ring.
        apply Rle_trans with (1 := Rabs_triang _ _). rewrite <- tech_pow_Rmult.
        replace (2 * B * (/ 2) ^ k * exp (2 * K * t) * (1 - / 2 * (/ 2) ^ m))
          with (B * ((/ 2) ^ k * (/ 2) ^ m) * exp (2 * K * t) + 2 * B * (/ 2) ^ k * exp (2 * K * t) * (1 - (/ 2) ^ m))
          by field. lra.
    - assert (0 <= (/ 2) ^ m) by (apply pow_le; lra).
      replace (2 * B * (/ 2) ^ k * exp (2 * K * t)) with (2 * B * (/ 2) ^ k * exp (2 * K * t) * 1) at 2 by ring.
      apply Rmult_le_compat_l; lra.
  Qed.

  Lemma small c eps : 0 <= c -> 0 < eps -> exists N, forall k, (N <= k)%nat -> c * (/ 2) ^ k < eps.
  Proof.
    intros Hc He. destruct (pow_lt_1_zero (/ 2)) with (y := eps / (c + 1)) as (N & H).
    - rewrite Rabs_pos_eq; lra.
    - apply Rdiv_lt_0_compat; lra.
    - exists N. intros k L. specialize (H k L). assert (0 <= (/ 2) ^ k) by (apply pow_le; lra).
      rewrite Rabs_pos_eq in H by assumption. apply Rle_lt_trans with ((c + 1) * (/ 2) ^ k); [lra|].
      apply Rlt_le_trans with ((c + 1) * (eps / (c + 1))); [apply Rmult_lt_compat_l; lra|].
      apply Req_le. field. lra.
  Qed.

  Lemma cauchy t i : Cauchy_crit (fun k => approximation k (Rmax 0 t) i).
  Proof.
    intros eps He. pose proof (Rmax_l 0 t) as Ht. set (s := Rmax 0 t) in *.
    assert (C : 0 <= 2 * B * exp (2 * K * s)) by (apply Rmult_le_pos; [lra|apply Rlt_le, exp_pos]).
    destruct (small (2 * B * exp (2 * K * s)) (eps / 2) C) as (N & H); [lra|]. exists N. intros k m Hk Hm.
    specialize (H N ltac:(lia)). unfold R_dist.
    pose proof (tail N (k - N) s i Ht) as Tk. pose proof (tail N (m - N) s i Ht) as Tm.
    replace (N + (k - N))%nat with k in Tk by lia. replace (N + (m - N))%nat with m in Tm by lia.
    rewrite Rabs_minus_sym in Tm.
    replace (approximation k s i - approximation m s i)
      with (approximation k s i - approximation N s i + (approximation N s i - approximation m s i)) by ring.
    apply Rle_lt_trans with (1 := Rabs_triang _ _). lra.
  Qed.

  (** The limit, for times from 0 on. *)
  Definition limit_curve (t : R) : vector := fun i => proj1_sig (R_complete _ (cauchy t i)).

  Lemma limit_converges t i : 0 <= t -> Un_cv (fun k => approximation k t i) (limit_curve t i).
  Proof.
    intros Ht. unfold limit_curve. destruct (R_complete _ (cauchy t i)) as (l & L). simpl.
    rewrite Rmax_right in L by exact Ht. exact L.
  Qed.

  Lemma limit_near k t i : 0 <= t -> Rabs (limit_curve t i - approximation k t i) <= 2 * B * (/ 2) ^ k * exp (2 * K *
    t).
  Proof.
    intros Ht. apply (limit_is_near _ _ k _ _ (limit_converges t i Ht)). intros m. apply tail, Ht.
  Qed.

  Lemma limit_start i : limit_curve 0 i = e0 i.
  Proof.
    apply (UL_sequence (fun k => approximation k 0 i)); [apply limit_converges; lra|].
    intros eps He. exists 0%nat. intros k _. rewrite approximation_start. unfold R_dist.
    rewrite Rminus_diag_eq, Rabs_R0; trivial.
  Qed.

  Lemma limit_slow t i : 0 <= t -> Rabs (limit_curve t i - e0 i) <= B * t.
  Proof.
    intros Ht. apply (limit_is_near _ _ 1 _ _ (limit_converges t i Ht)). intros m. simpl.
    apply (bounded_by_derivative (fun t => approximation (S m) t i - e0 i) (fun t => flow (approximation m t) i - 0)
      (fun t => B * t) (fun _ => B * 1)); try assumption.
    - intros s. apply (derivable_pt_lim_minus (fun s => approximation (S m) s i) (fun _ => e0 i));
        [apply approximation_derivative|apply derivable_pt_lim_const].
    - intros s. apply (derivable_pt_lim_scal id). apply derivable_pt_lim_id.
    - rewrite approximation_start. ring.
    - lra.
    - intros s _. rewrite Rminus_0_r, Rmult_1_r. apply flow_bounded.
  Qed.

  Lemma limit_derivative t i : 0 < t -> derivable_pt_lim (fun s => limit_curve s i) t (flow (limit_curve t) i).
  Proof.
    intros Ht. set (r := mkposreal t Ht).
    assert (In : forall y, Boule t r y -> 0 <= y /\ y <= 2 * t).
    { intros y Y. unfold Boule, r in Y. simpl in Y. apply Rabs_def2 in Y. lra. }
    assert (U : CVU (fun k s => flow (approximation k s) i) (fun s => flow (limit_curve s) i) t r).
    { intros eps He. set (c := K * (2 * B * exp (2 * K * (2 * t)))).
      assert (C : 0 <= c).
      { unfold c. apply Rmult_le_pos; [lra|]. apply Rmult_le_pos; [lra|apply Rlt_le, exp_pos]. }
      destruct (small c eps C He) as (N & H). exists N. intros k y Hk Y. destruct (In y Y) as [Y0 Y1].
      apply Rle_lt_trans with (2 := H k Hk).
      apply Rle_trans with (K * (2 * B * (/ 2) ^ k * exp (2 * K * y))).
      - apply flow_lipschitz.
        + apply Rmult_le_pos; [apply Rmult_le_pos; [lra|apply pow_le; lra]|apply Rlt_le, exp_pos].
        + intros j. apply limit_near, Y0.
      - unfold c. replace (K * (2 * B * exp (2 * K * (2 * t))) * (/ 2) ^ k)
          with (K * (2 * B * (/ 2) ^ k * exp (2 * K * (2 * t)))) by ring.
        apply Rmult_le_compat_l; [lra|]. apply Rmult_le_compat_l.
        + apply Rmult_le_pos; [lra|apply pow_le; lra].
        + assert (Z : 2 * K * y <= 2 * K * (2 * t)) by (apply Rmult_le_compat_l; lra).
          destruct Z as [Z| ->]; [apply Rlt_le, exp_increasing, Z|lra]. }
    apply (derivable_pt_lim_CVU (fun k s => approximation (S k) s i) (fun k s => flow (approximation k s) i)
      (fun s => limit_curve s i) (fun s => flow (limit_curve s) i) t t r).
    - unfold Boule. rewrite Rminus_diag_eq, Rabs_R0 by reflexivity. exact Ht.
    - intros y k _. apply approximation_derivative.
    - intros y Y eps He. destruct (limit_converges y i (proj1 (In y Y)) eps He) as (N & H). exists N. intros k Hk.
      apply H. lia.
    - exact U.
    - apply (CVU_continuity _ _ _ _ U). intros k y _. apply (flow_continuous (iterate k)).
  Qed.

  Theorem picard :
    exists e : R -> vector, (forall i, e 0 i = e0 i) /\ forall T, solution T n e (fun t => g (e t)).
  Proof.
    exists limit_curve. split; [exact limit_start|]. intros T i I. split.
    - intros eps He. exists (eps / (B + 1)). split; [apply Rdiv_lt_0_compat; lra|]. intros t Ht.
      rewrite limit_start. apply Rle_lt_trans with (1 := limit_slow t i (proj1 Ht)).
      apply Rle_lt_trans with ((B + 1) * t); [lra|].
      apply Rlt_le_trans with ((B + 1) * (eps / (B + 1))); [apply Rmult_lt_compat_l; lra|]. apply Req_le. field. lra.
    - intros t Ht. pose proof (limit_derivative t i (proj1 Ht)) as D. unfold flow in D.
      destruct (Nat.ltb_spec i n); [exact D|lia].
  Qed.
End Picard.

(** ** Functions that are bounded and Lipschitz where the entries are *)

Definition in_cube (n : nat) (r : R) (x : vector) : Prop := forall i, (i < n)%nat -> Rabs (x i) <= r.

Definition locally_lipschitz (n : nat) (f : vector -> R) : Prop := forall r, exists b k,
  0 <= b /\ 0 <= k /\ (forall x, in_cube n r x -> Rabs (f x) <= b)
  /\ forall x y d, 0 <= d -> in_cube n r x -> in_cube n r y -> (forall i, (i < n)%nat -> Rabs (x i - y i) <= d) ->
     Rabs (f x - f y) <= k * d.

Lemma lipschitz_constant n c : locally_lipschitz n (fun _ => c).
Proof.
  intros r. exists (Rabs c), 0. split; [apply Rabs_pos|]. split; [lra|]. split; [intros; lra|].
  intros. rewrite Rminus_diag_eq, Rabs_R0 by reflexivity. lra.
Qed.

Lemma lipschitz_entry n i : (i < n)%nat -> locally_lipschitz n (fun x => x i).
Proof.
  intros I r. exists (Rabs r), 1. split; [apply Rabs_pos|]. split; [lra|]. split.
  - intros x X. apply Rle_trans with (1 := X i I), Rle_abs.
  - intros x y d _ _ _ H. rewrite Rmult_1_l. apply H, I.
Qed.

Lemma lipschitz_plus n f g :
  locally_lipschitz n f -> locally_lipschitz n g -> locally_lipschitz n (fun x => f x + g x).
Proof.
  intros F G r. destruct (F r) as (b & k & B & K & Bf & Lf). destruct (G r) as (b' & k' & B' & K' & Bg & Lg).
  exists (b + b'), (k + k'). split; [lra|]. split; [lra|]. split.
  - intros x X. specialize (Bf x X). specialize (Bg x X). apply Rle_trans with (1 := Rabs_triang _ _). lra.
  - intros x y d D X Y H. specialize (Lf x y d D X Y H). specialize (Lg x y d D X Y H).
    replace (f x + g x - (f y + g y)) with (f x - f y + (g x - g y)) by ring.
    apply Rle_trans with (1 := Rabs_triang _ _). lra.
Qed.

Lemma lipschitz_times n f g :
  locally_lipschitz n f -> locally_lipschitz n g -> locally_lipschitz n (fun x => f x * g x).
Proof.
  intros F G r. destruct (F r) as (b & k & B & K & Bf & Lf). destruct (G r) as (b' & k' & B' & K' & Bg & Lg).
  exists (b * b'), (b * k' + k * b'). split; [apply Rmult_le_pos; assumption|].
  split; [apply Rplus_le_le_0_compat; apply Rmult_le_pos; assumption|]. split.
  - intros x X. rewrite Rabs_mult. apply Rmult_le_compat; try apply Rabs_pos; [apply Bf|apply Bg]; exact X.
  - intros x y d D X Y H. specialize (Lf x y d D X Y H). specialize (Lg x y d D X Y H).
    replace (f x * g x - f y * g y) with (f x * (g x - g y) + (f x - f y) * g y) by ring.
    apply Rle_trans with (1 := Rabs_triang _ _). rewrite !Rabs_mult, Rmult_plus_distr_r.
    apply Rplus_le_compat.
    + rewrite Rmult_assoc. apply Rmult_le_compat; try apply Rabs_pos; [apply Bf, X|exact Lg].
    + replace (k * b' * d) with (k * d * b') by ring.
      apply Rmult_le_compat; try apply Rabs_pos; [exact Lf|apply Bg, Y].
Qed.

Lemma lipschitz_sum n m (f : nat -> vector -> R) :
  (forall j, (j < m)%nat -> locally_lipschitz n (f j)) -> locally_lipschitz n (fun x => sum m (fun j => f j x)).
Proof.
  induction m as [|m IH]; intros H; simpl.
  - apply lipschitz_constant.
  - apply (lipschitz_plus n (fun x => sum m (fun j => f j x)) (f m)); [apply IH; intros; apply H; lia|apply H; lia].
Qed.

Lemma lipschitz_apply n m A (h : vector -> vector) i :
  (forall j, (j < m)%nat -> locally_lipschitz n (fun x => h x j)) -> locally_lipschitz n (fun x => apply m A (h x) i).
Proof.
  intros H. unfold apply. apply (lipschitz_sum n m (fun j x => A i j * h x j)). intros j J.
  apply (lipschitz_times n (fun _ => A i j)); [apply lipschitz_constant|apply H, J].
Qed.

Lemma lipschitz_form n m A (h : vector -> vector) :
  (forall j, (j < m)%nat -> locally_lipschitz n (fun x => h x j)) -> locally_lipschitz n (fun x => form m A (h x)).
Proof.
  intros H. unfold form, bilinear. apply (lipschitz_sum n m (fun i x => h x i * apply m A (h x) i)). intros i I.
  apply (lipschitz_times n (fun x => h x i)); [apply H, I|apply lipschitz_apply, H].
Qed.

(** The largest of the bounds of all entries. *)
Lemma lipschitz_entries n m (g : vector -> vector) r :
  (forall i, (i < m)%nat -> locally_lipschitz n (fun x => g x i)) ->
  exists b k, 0 <= b /\ 1 <= k /\ forall i, (i < m)%nat ->
  (forall x, in_cube n r x -> Rabs (g x i) <= b)
  /\ forall x y d, 0 <= d -> in_cube n r x -> in_cube n r y -> (forall j, (j < n)%nat -> Rabs (x j - y j) <= d) ->
     Rabs (g x i - g y i) <= k * d.
Proof.
  induction m as [|m IH]; intros H.
  - exists 0, 1. repeat split; try lra; intros; lia.
  - destruct IH as (b & k & B & K & All); [intros; apply H; lia|].
    destruct (H m ltac:(lia) r) as (b' & k' & B' & K' & Bm & Lm). exists (b + b'), (k + k').
    split; [lra|]. split; [lra|]. intros i I. destruct (Nat.eq_dec i m) as [->|N].
    + split.
      * intros x X. specialize (Bm x X). lra.
      * intros x y d D X Y L. specialize (Lm x y d D X Y L). assert (0 <= k * d) by (apply Rmult_le_pos; lra). lra.
    + destruct (All i ltac:(lia)) as [Bi Li]. split.
      * intros x X. specialize (Bi x X). lra.
      * intros x y d D X Y L. specialize (Li x y d D X Y L). assert (0 <= k' * d) by (apply Rmult_le_pos; lra). lra.
Qed.

(** ** Entries kept between bounds *)

Definition clamp (r : R) (x : vector) : vector := fun i => Rmax (- r) (Rmin r (x i)).

Lemma clamp_in_cube n r x : 0 <= r -> in_cube n r (clamp r x).
Proof.
  intros H i _. unfold clamp. apply Rabs_le. unfold Rmax, Rmin.
  destruct (Rle_dec r (x i)); [destruct (Rle_dec (- r) r)|destruct (Rle_dec (- r) (x i))]; lra.
Qed.

Lemma clamp_same r x i : Rabs (x i) <= r -> clamp r x i = x i.
Proof.
  intros H. pose proof (Rle_abs (x i)). pose proof (Rle_abs (- x i)). rewrite Rabs_Ropp in *. unfold clamp, Rmax, Rmin.
  destruct (Rle_dec r (x i)); [destruct (Rle_dec (- r) r)|destruct (Rle_dec (- r) (x i))]; lra.
Qed.

Lemma clamp_near r x y i : 0 <= r -> Rabs (clamp r x i - clamp r y i) <= Rabs (x i - y i).
Proof.
  intros H. unfold clamp, Rmax, Rmin.
  destruct (Rle_dec r (x i)), (Rle_dec r (y i)); repeat destruct (Rle_dec _ _);
    unfold Rabs; repeat destruct (Rcase_abs _); lra.
Qed.

(** ** Where V falls *)

Theorem falling_solutions_exist n (P : matrix) lower level (g : vector -> vector) :
  0 < lower -> (forall v, lower * square n v <= form n P v) ->
  (forall i, (i < n)%nat -> locally_lipschitz n (fun x => g x i)) ->
  (forall v, form n P v < level -> bilinear n n P (g v) v + bilinear n n P v (g v) <= 0) ->
  forall e0, form n P e0 < level ->
  exists e : R -> vector, (forall i, e 0 i = e0 i) /\ forall T, solution T n e (fun t => g (e t)).
Proof.
  intros Positive Lower Smooth Falls e0 Below.
  assert (Level : 0 < level).
  { pose proof (Lower e0). assert (0 <= lower * square n e0) by (apply Rmult_le_pos;
    [lra|apply square_nonnegative]). lra. }
  assert (0 < level / lower) by (apply Rdiv_lt_0_compat; assumption).
  set (r := level / lower + 1).
  assert (Inside : forall v, form n P v < level -> in_cube n r v).
  { intros v V i I. specialize (Lower v).
    assert (S : v i * v i <= level / lower).
    { apply Rle_trans with (square n v).
      - apply (term_le_sum n (fun j => v j * v j)); [|exact I]. intros. apply Rle_0_sqr.
      - apply Rmult_le_reg_l with lower; [exact Positive|].
        replace (lower * (level / lower)) with level by (field; lra). lra. }
    apply Rnot_lt_le. intros A. assert (Q : v i * v i = Rabs (v i) * Rabs (v i)).
    { rewrite <- Rabs_mult. symmetry. apply Rabs_pos_eq, Rle_0_sqr. }
    rewrite Q in S. unfold r in A. nra. }
  destruct (lipschitz_entries n n g r Smooth) as (b & k & B & K & All).
  assert (Clamped : forall v, form n P v < level -> forall i, (i < n)%nat -> g (clamp r v) i = g v i).
  { intros v V i I. destruct (All i I) as [_ L].
    assert (C : Rabs (g (clamp r v) i - g v i) <= k * 0).
    { apply L; [lra|apply clamp_in_cube; unfold r; lra|apply Inside, V|].
      intros j J. rewrite clamp_same by (apply Inside; assumption). rewrite Rminus_diag_eq, Rabs_R0 by reflexivity.
        lra. }
    rewrite Rmult_0_r in C. pose proof (Rle_abs (g (clamp r v) i - g v i)).
    pose proof (Rle_abs (- (g (clamp r v) i - g v i))). rewrite Rabs_Ropp in *. lra. }
  destruct (picard n (fun v => g (clamp r v)) b k e0 K B) as (e & Start & E).
  { intros x i I. apply (All i I). apply clamp_in_cube. unfold r. lra. }
  { intros x y d D H' i I. apply (All i I); try assumption; try (apply clamp_in_cube; unfold r; lra).
    intros j J. apply Rle_trans with (1 := clamp_near r x y j ltac:(unfold r; lra)), H', J. }
  assert (V0 : form n P (e 0) < level).
  { rewrite (form_ext n P P (e 0) e0); [exact Below|easy|]. intros i _. apply Start. }
  assert (Stays : forall t, 0 <= t -> form n P (e t) < level).
  { intros t Ht. apply Rle_lt_trans with (form n P (e 0)); [|exact V0].
    apply (stays_below (t + 1) (fun t => form n P (e t))
      (fun t => bilinear n n P (g (clamp r (e t))) (e t) + bilinear n n P (e t) (g (clamp r (e t)))) level); try lra.
    - apply right_continuous_form. intros i I. apply (E (t + 1) i I).
    - intros s S. apply derivative_form. intros i I. apply (E (t + 1) i I). exact S.
    - intros s _ V. specialize (Falls (e s) V).
      rewrite (bilinear_ext n n P P (g (clamp r (e s))) (e s) (g (e s)) (e s)); [|easy|apply Clamped, V|easy].
      rewrite (bilinear_ext n n P P (e s) (g (clamp r (e s))) (e s) (g (e s)));
        [exact Falls|easy|easy|apply Clamped, V]. }
  exists e. split; [exact Start|]. intros T i I. destruct (E T i I) as [C D]. split; [exact C|].
  intros t Ht. rewrite <- (Clamped (e t)); [apply D, Ht|apply Stays; lra|exact I].
Qed.

(** The same where V does not grow anywhere. *)
Theorem decaying_solutions_exist n (P : matrix) lower (g : vector -> vector) :
  0 < lower -> (forall v, lower * square n v <= form n P v) ->
  (forall i, (i < n)%nat -> locally_lipschitz n (fun x => g x i)) ->
  (forall v, bilinear n n P (g v) v + bilinear n n P v (g v) <= 0) ->
  forall e0, exists e : R -> vector, (forall i, e 0 i = e0 i) /\ forall T, solution T n e (fun t => g (e t)).
Proof.
  intros Positive Lower Smooth Falls e0.
  apply (falling_solutions_exist n P lower (form n P e0 + 1) g Positive Lower Smooth); [intros; apply Falls|lra].
Qed.
