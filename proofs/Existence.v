(** Linear differential equations have solutions for all times: [e' = F e], [e(0) = e0], by the series of
    [exp(F t)e0], whose coefficients are [F^k e0 / k!]. *)

From Coq Require Import Reals QArith Qreals List Lra Lia PSeries_reg Ranalysis5.
From Luenberger Require Import Vectors Definite Inequalities Decay LinearObserver.
Import ListNotations.
Local Open Scope R_scope.

(** ** Uniform convergence *)

Lemma uniform_sum k (w : nat -> R) (fn : nat -> nat -> R -> R) (f : nat -> R -> R) c r :
  (forall j, CVU (fn j) (f j) c r) ->
  CVU (fun N y => sum k (fun j => w j * fn j N y)) (fun y => sum k (fun j => w j * f j y)) c r.
Proof.
  intros H. induction k as [|k IH]; intros eps He; simpl.
  - exists 0%nat. intros. rewrite Rminus_diag_eq, Rabs_R0; trivial.
  - destruct (IH (eps / 2)) as (N & K); [lra|].
    assert (W : 0 < Rabs (w k) + 1) by (pose proof (Rabs_pos (w k)); lra).
    destruct (H k (eps / 2 / (Rabs (w k) + 1))) as (M & L).
    { apply Rdiv_lt_0_compat; lra. }
    exists (Nat.max N M). intros n y Hn Hy.
    specialize (K n y ltac:(lia) Hy). specialize (L n y ltac:(lia) Hy).
    replace (sum k (fun j => w j * f j y) + w k * f k y - (sum k (fun j => w j * fn j n y) + w k * fn k n y))
      with (sum k (fun j => w j * f j y) - sum k (fun j => w j * fn j n y) + w k * (f k y - fn k n y)) by ring.
    apply Rle_lt_trans with (1 := Rabs_triang _ _). rewrite Rabs_mult.
    assert (Rabs (w k) * Rabs (f k y - fn k n y) <= (Rabs (w k) + 1) * Rabs (f k y - fn k n y)).
    { apply Rmult_le_compat_r; [apply Rabs_pos|lra]. }
    assert ((Rabs (w k) + 1) * Rabs (f k y - fn k n y) < eps / 2).
    { apply Rlt_le_trans with ((Rabs (w k) + 1) * (eps / 2 / (Rabs (w k) + 1))).
      - apply Rmult_lt_compat_l; assumption.
      - apply Req_le. field. lra. }
    lra.
Qed.

Lemma uniform_shift (fn : nat -> R -> R) f c r :
  CVU fn f c r -> CVU (fun N => match N with O => fun _ => 0 | S M => fn M end) f c r.
Proof.
  intros H eps He. destruct (H eps He) as (N & K). exists (S N). intros [|n] y Hn Hy; [lia|]. apply K; [lia|exact Hy].
Qed.

Section Linear.
  Variables (n : nat) (F : matrix) (e0 : vector).

  (** [F^k e0 / k!] *)
  Fixpoint coefficient (k : nat) : vector :=
    match k with
    | O => fun i => if Nat.ltb i n then e0 i else 0
    | S l => fun i => if Nat.ltb i n then / INR (S l) * apply n F (coefficient l) i else 0
    end.

  Let m := sum n (fun i => sum n (fun j => Rabs (F i j))).
  Let c := sum n (fun i => Rabs (e0 i)).

  Lemma m_nonnegative : 0 <= m.
  Proof. apply sum_nonnegative. intros. apply sum_nonnegative. intros. apply Rabs_pos. Qed.

  Lemma c_nonnegative : 0 <= c.
  Proof. apply sum_nonnegative. intros. apply Rabs_pos. Qed.

  Lemma apply_bound (a : vector) b i :
    (i < n)%nat -> (forall j, Rabs (a j) <= b) -> Rabs (apply n F a i) <= m * b.
  Proof.
    intros I H. apply Rle_trans with (sum n (fun j => Rabs (F i j)) * b).
    - unfold apply. rewrite <- sum_times_right. generalize n as k. induction k as [|k IH]; simpl.
      + rewrite Rabs_R0. lra.
      + apply Rle_trans with (1 := Rabs_triang _ _). rewrite Rabs_mult.
        assert (Rabs (F i k) * Rabs (a k) <= Rabs (F i k) * b) by (apply Rmult_le_compat_l; [apply Rabs_pos|apply H]).
        lra.
    - apply Rmult_le_compat_r; [apply Rle_trans with (2 := H 0%nat), Rabs_pos|].
      apply (term_le_sum n (fun i => sum n (fun j => Rabs (F i j)))); [|exact I]. intros. apply sum_nonnegative. intros.
      apply Rabs_pos.
  Qed.

  Lemma coefficient_bound k : forall i, Rabs (coefficient k i) <= c * (/ INR (fact k) * m ^ k).
  Proof.
    induction k as [|k IH]; intros i; cbn [coefficient].
    - replace (c * (/ INR (fact 0) * m ^ 0)) with c by (simpl; field). destruct (Nat.ltb_spec i n) as [L|L].
      + apply (term_le_sum n (fun i => Rabs (e0 i))); [|exact L]. intros. apply Rabs_pos.
      + rewrite Rabs_R0. apply c_nonnegative.
    - assert (Fk : 0 < INR (fact k)) by apply INR_fact_lt_0. assert (Sk : 0 < INR (S k)) by (apply lt_0_INR; lia).
      replace (c * (/ INR (fact (S k)) * m ^ S k)) with (/ INR (S k) * (m * (c * (/ INR (fact k) * m ^ k)))).
      2: { rewrite fact_simpl, mult_INR. simpl pow. field. split; lra. }
      destruct (Nat.ltb_spec i n) as [L|L].
      + rewrite Rabs_mult, Rabs_pos_eq by (apply Rlt_le, Rinv_0_lt_compat, Sk).
        apply Rmult_le_compat_l; [apply Rlt_le, Rinv_0_lt_compat, Sk|]. apply apply_bound; assumption.
      + rewrite Rabs_R0. apply Rmult_le_pos; [apply Rlt_le, Rinv_0_lt_compat, Sk|].
        apply Rmult_le_pos; [apply m_nonnegative|]. apply Rle_trans with (2 := IH 0%nat), Rabs_pos.
  Qed.

  Definition term (i k : nat) (t : R) : R := coefficient k i * t ^ k.

  Lemma normally (i : nat) : CVN_R (term i).
  Proof.
    intros r. exists (fun k => c * (/ INR (fact k) * (m * r) ^ k)).
    destruct (exist_exp (m * r)) as (l & L). exists (c * l). split.
    - assert (Positive : forall k, 0 <= c * (/ INR (fact k) * (m * r) ^ k)).
      { intros k. apply Rmult_le_pos; [apply c_nonnegative|]. apply Rmult_le_pos.
        - apply Rlt_le, Rinv_0_lt_compat, INR_fact_lt_0.
        - apply pow_le, Rmult_le_pos; [apply m_nonnegative|apply Rlt_le, r]. }
      assert (E : forall N, sum_f_R0 (fun k => Rabs (c * (/ INR (fact k) * (m * r) ^ k))) N
        = c * sum_f_R0 (fun k => / INR (fact k) * (m * r) ^ k) N).
      { intros N. rewrite scal_sum. apply sum_eq. intros k _. rewrite Rabs_pos_eq by apply Positive. ring. }
      intros eps He. assert (C : 0 < c + 1) by (pose proof c_nonnegative; lra).
      destruct (L (eps / (c + 1))) as (N & K); [apply Rlt_gt, Rdiv_lt_0_compat; lra|].
      exists N. intros k Hk. specialize (K k Hk). rewrite E. unfold R_dist in *.
      rewrite <- Rmult_minus_distr_l, Rabs_mult, (Rabs_pos_eq c) by apply c_nonnegative.
      set (x := Rabs (sum_f_R0 (fun i0 => / INR (fact i0) * (m * r) ^ i0) k - l)) in *.
      assert (0 <= x) by apply Rabs_pos. pose proof c_nonnegative.
      apply Rle_lt_trans with ((c + 1) * x); [lra|].
      apply Rlt_le_trans with ((c + 1) * (eps / (c + 1))); [apply Rmult_lt_compat_l; assumption|].
      apply Req_le. field. lra.
    - intros k y Hy. unfold term. rewrite Rabs_mult, Rpow_mult_distr.
      replace (c * (/ INR (fact k) * (m ^ k * r ^ k))) with (c * (/ INR (fact k) * m ^ k) * r ^ k) by ring.
      apply Rmult_le_compat; try apply Rabs_pos; [apply coefficient_bound|].
      rewrite <- RPow_abs. apply pow_incr. split; [apply Rabs_pos|]. unfold Boule in Hy. rewrite Rminus_0_r in Hy. lra.
  Qed.

  Definition converges (i : nat) (x : R) : { l : R | Un_cv (fun N => SP (term i) N x) l } :=
    CVN_R_CVS (term i) (normally i) x.

  (** [exp(F t)e0] *)
  Definition exponential (t : R) : vector := fun i => SFL (term i) (converges i) t.

  Lemma term_continuous i k : continuity (term i k).
  Proof. intros y. apply derivable_continuous_pt. unfold term. reg. Qed.

  Lemma exponential_continuous i : continuity (fun t => exponential t i).
  Proof. apply SFL_continuity; [apply normally|apply term_continuous]. Qed.

  Lemma partial_derivative i N y : (i < n)%nat ->
    derivable_pt_lim (SP (term i) N) y
      (match N with O => 0 | S M => sum n (fun j => F i j * SP (term j) M y) end).
  Proof.
    intros I. induction N as [|N IH].
    - apply (derivable_pt_lim_ext (fun _ => term i 0%nat 0)); [intros; unfold SP, term; simpl; ring|].
      apply derivable_pt_lim_const.
    - assert (D : derivable_pt_lim (term i (S N)) y (sum n (fun j => F i j * term j N y))).
      { unfold term. replace (sum n (fun j => F i j * (coefficient N j * y ^ N)))
          with (coefficient (S N) i * (INR (S N) * y ^ pred (S N))).
        - apply (derivable_pt_lim_scal (fun t => t ^ S N)). apply derivable_pt_lim_pow.
        - cbn [coefficient pred]. destruct (Nat.ltb_spec i n); [|lia]. unfold apply.
          rewrite (sum_ext n (fun j => F i j * (coefficient N j * y ^ N)) (fun j => F i j * coefficient N j * y ^ N))
            by (intros; ring).
          rewrite sum_times_right. field. apply not_0_INR. lia. }
      apply (derivable_pt_lim_ext (fun t => SP (term i) N t + term i (S N) t)); [intros; reflexivity|].
      replace (sum n (fun j => F i j * SP (term j) N y))
        with (match N with O => 0 | S M => sum n (fun j => F i j * SP (term j) M y) end
              + sum n (fun j => F i j * term j N y)).
      + apply derivable_pt_lim_plus; [exact IH|exact D].
      + destruct N as [|N].
        * rewrite Rplus_0_l. reflexivity.
        * rewrite <- sum_plus. apply sum_ext. intros j _. unfold SP. simpl. ring.
  Qed.

  Lemma sum_continuous k (w : nat -> R) (f : nat -> R -> R) :
    (forall j, continuity (f j)) -> continuity (fun y => sum k (fun j => w j * f j y)).
  Proof.
    intros H. induction k as [|k IH]; simpl.
    - intros y. apply continuity_pt_const. intros a b. reflexivity.
    - apply (continuity_plus (fun y => sum k (fun j => w j * f j y)) (fun y => w k * f k y)); [exact IH|].
      apply (continuity_scal (f k)), H.
  Qed.

  Theorem exponential_derivative i x :
    (i < n)%nat -> derivable_pt_lim (fun t => exponential t i) x (apply n F (exponential x) i).
  Proof.
    intros I. assert (Hr : 0 < Rabs x + 1) by (pose proof (Rabs_pos x); lra). set (r := mkposreal _ Hr).
    apply (derivable_pt_lim_CVU (fun N => SP (term i) N)
      (fun N => match N with O => fun _ => 0 | S M => fun y => sum n (fun j => F i j * SP (term j) M y) end)
      (fun t => exponential t i) (fun y => apply n F (exponential y) i) x 0 r).
    - unfold Boule, r. simpl. rewrite Rminus_0_r. lra.
    - intros y N _. pose proof (partial_derivative i N y I) as D. destruct N; exact D.
    - intros y _. unfold exponential, SFL. destruct (converges i y) as (l & L). exact L.
    - apply (uniform_shift (fun M y => sum n (fun j => F i j * SP (term j) M y))).
      apply (uniform_sum n (F i) (fun j M y => SP (term j) M y) (fun j y => exponential y j)). intros j.
      apply CVN_CVU, normally.
    - intros y _. apply (sum_continuous n (F i) (fun j y => exponential y j)). intros j. apply exponential_continuous.
  Qed.

  Lemma exponential_start i : (i < n)%nat -> exponential 0 i = e0 i.
  Proof.
    intros I. unfold exponential, SFL. destruct (converges i 0) as (l & L).
    apply (UL_sequence _ _ _ L). intros eps He. exists 0%nat. intros N _.
    replace (SP (term i) N 0) with (e0 i); [unfold R_dist; rewrite Rminus_diag_eq, Rabs_R0; trivial|].
    assert (Z : term i 0 0 = e0 i) by (unfold term; simpl; destruct (Nat.ltb_spec i n); [ring|lia]).
    unfold SP. induction N as [|N IH]; [symmetry; exact Z|]. cbn [sum_f_R0]. rewrite <- IH. unfold term. simpl. ring.
  Qed.

  Theorem linear_solution_exists :
    exists e : R -> vector, (forall i, (i < n)%nat -> e 0 i = e0 i) /\ forall T, solution T n e (fun t => apply n F (e
      t)).
  Proof.
    exists exponential. split; [exact exponential_start|]. intros T i I. split.
    - apply (right_continuous_derivable _ _ (exponential_derivative i 0 I)).
    - intros t _. apply exponential_derivative, I.
  Qed.
End Linear.

(** From every e(0) there is a solution of the error of the linear observer, for all times. *)
Theorem error_exists n p A C L :
  linear_fits n p A C L A = true ->
  forall e0 : vector, exists e : R -> vector, (forall i, (i < n)%nat -> e 0 i = e0 i) /\ forall T,
  solution T n e (fun t => A * e t - L * (C * e t))%vector.
Proof.
  intros Fit e0. destruct (linear_fits_parts _ _ _ _ _ _ Fit) as (FA & FC & FL & _).
  destruct (linear_solution_exists n (error_matrix p A C L) e0) as (e & Start & E). exists e. split; [exact Start|].
  intros T. apply (solution_ext T n e (fun t => apply n (error_matrix p A C L) (e t))); [|apply E].
  intros t i I. symmetry. apply (error_apply n p); try exact I; eapply fits_shape; eassumption.
Qed.
