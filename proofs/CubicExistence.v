(** The errors of the cubic observer, and its loop, exist for all times: from every e(0), or from below the level, there
    is a solution of the equations that CubicObserver.v, CubicRegion.v and FeedbackLoop.v are about. *)

From Coq Require Import Reals QArith Qreals ZArith List Lra Lia FunctionalExtensionality.
From Luenberger Require Import Vectors Definite Inequalities Decay LinearObserver CubicObserver CubicRegion FeedbackLoop
  Blocks Solutions.
Import ListNotations.
Local Open Scope R_scope.
Local Open Scope lazy_bool_scope.

(** ** Right sides are locally Lipschitz *)

Lemma lipschitz_ext n f g : (forall x, f x = g x) -> locally_lipschitz n f -> locally_lipschitz n g.
Proof.
  intros E F r. destruct (F r) as (b & k & B & K & Bf & Lf). exists b, k. split; [exact B|]. split; [exact K|]. split.
  - intros x X. rewrite <- E. apply Bf, X.
  - intros x y d D X Y H. rewrite <- !E. apply Lf; assumption.
Qed.

Lemma lipschitz_minus n f g :
  locally_lipschitz n f -> locally_lipschitz n g -> locally_lipschitz n (fun x => f x - g x).
Proof.
  intros F G. apply (lipschitz_ext n (fun x => f x + -1 * g x)); [intros; ring|].
  apply (lipschitz_plus n f (fun x => -1 * g x)); [exact F|].
  apply (lipschitz_times n (fun _ => -1) g); [apply lipschitz_constant|exact G].
Qed.

Lemma lipschitz_matrix n k m A (h : vector -> vector) i :
  has_shape k m A = true -> (i < k)%nat -> (forall j, (j < m)%nat -> locally_lipschitz n (fun x => h x j)) ->
  locally_lipschitz n (fun x => (A * h x)%vector i).
Proof.
  intros HA I H. apply (lipschitz_ext n (fun x => apply m (real A) (h x) i)).
  - intros x. symmetry. apply (times_vector_apply k m); assumption.
  - apply lipschitz_apply, H.
Qed.

(** The error, as a function of a vector h(x). *)
Lemma lipschitz_cubic_error N' n p A C L theta N (h : vector -> vector) i :
  has_shape n n A = true -> has_shape p n C = true -> has_shape n p L = true -> has_shape p p theta = true ->
  (i < n)%nat -> (forall j, (j < n)%nat -> locally_lipschitz N' (fun x => h x j)) ->
  locally_lipschitz N' (fun x => cubic_error p A C L theta N (h x) i).
Proof.
  intros HA HC HL Ht I H.
  apply (lipschitz_ext N' (fun x => cubic_flow n p A C L theta N (h x) i)).
  { intros x. symmetry. apply cubic_error_flow; assumption. }
  assert (Y : forall j, (j < p)%nat -> locally_lipschitz N' (fun x => apply n (real C) (h x) j)).
  { intros j _. apply lipschitz_apply, H. }
  unfold cubic_flow.
  apply (lipschitz_plus N' (fun x => apply n (error_matrix p A C L) (h x) i)); [apply lipschitz_apply, H|].
  apply (lipschitz_times N' (fun x => form p (real theta) (apply n (real C) (h x)))).
  - apply (lipschitz_form N' p (real theta) (fun x => apply n (real C) (h x))), Y.
  - apply (lipschitz_apply N' p N (fun x => apply n (real C) (h x))), Y.
Qed.

(** ** The error *)

Lemma errors_exist_below n p A C L P theta N lower upper overshoot level :
  is_between n P lower upper overshoot = true ->
  has_shape n n A = true -> has_shape p n C = true -> has_shape n p L = true -> has_shape p p theta = true ->
  (forall v, form n (real P) v < level -> let f := cubic_flow n p A C L theta N v in
    bilinear n n (real P) f v + bilinear n n (real P) v f <= 0) ->
  forall e0, form n (real P) e0 < level ->
  exists e : R -> vector, (forall i, (i < n)%nat -> e 0 i = e0 i)
    /\ forall T, solution T n e (fun t => cubic_error p A C L theta N (e t)).
Proof.
  intros Between HA HC HL Ht Falls e0 Below. destruct (between_numbers _ _ _ _ _ Between) as (Lower & _ & _).
  destruct (falling_solutions_exist n (real P) (Q2R lower) level (cubic_error p A C L theta N) Lower
    (between_lower _ _ _ _ _ Between)) with (e0 := e0) as (e & Start & E); try assumption.
  - intros i I. apply (lipschitz_cubic_error n n p A C L theta N (fun x => x)); try assumption.
    intros j J. apply lipschitz_entry, J.
  - intros v V. specialize (Falls v V). cbv zeta in Falls.
    assert (F : forall i, (i < n)%nat -> cubic_error p A C L theta N v i = cubic_flow n p A C L theta N v i).
    { intros i I. apply cubic_error_flow; assumption. }
    rewrite (bilinear_ext n n (real P) (real P) _ v (cubic_flow n p A C L theta N v) v); [|easy|exact F|easy].
    rewrite (bilinear_ext n n (real P) (real P) v _ v (cubic_flow n p A C L theta N v));
      [exact Falls|easy|easy|exact F].
  - exists e. split; [intros; apply Start|exact E].
Qed.

(** From every e(0). *)
Theorem cubic_errors_exist n p A C L P theta a lower upper overshoot :
  cubic_decays n p A C L P theta a lower upper overshoot = true -> Qle_bool 0 a = true ->
  forall N, dissipates n p C P N -> forall e0 : vector, exists e : R -> vector, (forall i, (i < n)%nat -> e 0 i = e0 i)
    /\ forall T, solution T n e (fun t => cubic_error p A C L theta N (e t)).
Proof.
  intros Checked Sign N Dissipates e0. apply not_negative in Sign.
  destruct (cubic_parts _ _ _ _ _ _ _ _ _ _ _ Checked) as (Decays & _ & _ & Ht).
  destruct (shapes _ _ _ _ _ _ _ _ _ _ Decays) as (HA & HC & HL & _). pose proof (both _ _ Decays) as [Between _].
  destruct (between_numbers _ _ _ _ _ Between) as (Lower & _ & _).
  apply (errors_exist_below n p A C L P theta N lower upper overshoot (form n (real P) e0 + 1) Between);
    try assumption; [|lra].
  intros v _ f. pose proof (cubic_flow_falls _ _ _ _ _ _ _ _ _ _ _ Checked N Dissipates v) as K. cbv zeta in K. fold f
    in K.
  assert (0 <= form n (real P) v).
  { apply Rle_trans with (2 := between_lower _ _ _ _ _ Between v).
    apply Rmult_le_pos; [lra|apply square_nonnegative]. }
  assert (0 <= 2 * Q2R a * form n (real P) v) by (apply Rmult_le_pos; lra). lra.
Qed.

(** From below the level. *)
Theorem region_errors_exist n p A C L N P theta S q lower upper overshoot mu t rho kappa level decay :
  region_decays n p A C L N P theta S q lower upper overshoot mu t rho kappa level decay = true ->
  forall e0 : vector, quadratic n P e0 < Q2R level ->
  exists e : R -> vector, (forall i, (i < n)%nat -> e 0 i = e0 i)
    /\ forall T, solution T n e (fun t => cubic_error p A C L theta (real N) (e t)).
Proof.
  intros Checked e0 Below.
  destruct (region_shapes _ _ _ _ _ _ _ _ _ _ _ _ _ _ _ _ _ _ _ Checked)
    as (Between & Decay & Level & Rate & _ & HA & HC & HL & HP & Ht).
  destruct (between_numbers _ _ _ _ _ Between) as (Lower & _ & _).
  rewrite quadratic_form in Below by exact HP.
  apply (errors_exist_below n p A C L P theta (real N) lower upper overshoot (Q2R level) Between); try assumption.
  intros v Small f. pose proof (region_flow_decays _ _ _ _ _ _ _ _ _ _ _ _ _ _ _ _ _ _ _ Checked v Small) as K.
  fold f in K. set (V := form n (real P) v) in *.
  assert (0 <= V).
  { apply Rle_trans with (2 := between_lower _ _ _ _ _ Between v).
    apply Rmult_le_pos; [lra|apply square_nonnegative]. }
  assert (0 <= 1 - V / Q2R level).
  { apply Rmult_le_reg_l with (Q2R level); [exact Level|].
    replace (Q2R level * (1 - V / Q2R level)) with (Q2R level - V) by (field; lra). lra. }
  assert (0 <= 2 * Q2R decay * (1 - V / Q2R level) * V).
  { apply Rmult_le_pos; [apply Rmult_le_pos; lra|assumption]. }
  lra.
Qed.

(** ** The loop *)

(** The second of a pair of n entries each. *)
Definition second (n : nat) (z : vector) : vector := fun i => z (n + i)%nat.

Lemma pair_of_halves n z i : (i < n + n)%nat -> pair_of n z (second n z) i = z i.
Proof.
  revert i. apply each_of_pair; intros i I; [rewrite pair_first by exact I|rewrite pair_second]; reflexivity.
Qed.

Section Loop.
  Variables (n m p : nat) (A B C K L theta : list (list Q)) (N : matrix).
  Hypothesis HA : has_shape n n A = true.
  Hypothesis HB : has_shape n m B = true.
  Hypothesis HC : has_shape p n C = true.
  Hypothesis HK : has_shape m n K = true.
  Hypothesis HL : has_shape n p L = true.
  Hypothesis Htheta : has_shape p p theta = true.

  Definition pair_flow (z : vector) : vector :=
    pair_of n (loop_flow A B K z (second n z)) (cubic_error p A C L theta N (second n z)).

  Lemma pair_flow_lipschitz i : (i < n + n)%nat -> locally_lipschitz (n + n) (fun z => pair_flow z i).
  Proof.
    assert (First : forall j, (j < n)%nat -> locally_lipschitz (n + n) (fun z => z j)).
    { intros j J. apply lipschitz_entry. lia. }
    assert (Second : forall j, (j < n)%nat -> locally_lipschitz (n + n) (fun z => second n z j)).
    { intros j J. apply (lipschitz_entry (n + n) (n + j)). lia. }
    revert i. apply each_of_pair; intros i I.
    - apply (lipschitz_ext (n + n) (fun z => loop_flow A B K z (second n z) i)).
      { intros z. symmetry. apply pair_first, I. }
      unfold loop_flow, plus_vector, minus_vector.
      apply (lipschitz_plus (n + n) (fun z => (A * z)%vector i - (B * (K * z))%vector i)).
      + apply (lipschitz_minus (n + n) (fun z => (A * z)%vector i)).
        * apply (lipschitz_matrix (n + n) n n A (fun z => z)); assumption.
        * apply (lipschitz_matrix (n + n) n m B (fun z => (K * z)%vector)); try assumption. intros j J.
          apply (lipschitz_matrix (n + n) m n K (fun z => z)); assumption.
      + apply (lipschitz_matrix (n + n) n m B (fun z => (K * second n z)%vector)); try assumption. intros j J.
        apply (lipschitz_matrix (n + n) m n K (second n)); assumption.
    - apply (lipschitz_ext (n + n) (fun z => cubic_error p A C L theta N (second n z) i)).
      { intros z. symmetry. apply pair_second. }
      apply (lipschitz_cubic_error (n + n) n p A C L theta N (second n)); assumption.
  Qed.

  (** Plant and observer, where a form of (x, e) falls below a level. *)
  Lemma loops_exist_below M lower level :
    0 < lower -> (forall v w, lower * (square n v + square n w) <= form (n + n) M (pair_of n v w)) ->
    (forall v w, form (n + n) M (pair_of n v w) < level ->
      let f := pair_of n (loop_flow A B K v w) (cubic_error p A C L theta N w) in
      bilinear (n + n) (n + n) M f (pair_of n v w) + bilinear (n + n) (n + n) M (pair_of n v w) f <= 0) ->
    forall x0 xhat0 : vector, form (n + n) M (pair_of n x0 (x0 - xhat0)%vector) < level ->
    exists x xhat : R -> vector, (forall i, (i < n)%nat -> x 0 i = x0 i /\ xhat 0 i = xhat0 i) /\ forall T,
      solution T n x (fun t => A * x t - B * (K * xhat t))%vector
      /\ solution T n xhat (fun t => let r := (C * x t - C * xhat t)%vector in
           (A * xhat t - B * (K * xhat t) + L * r - quadratic p theta r .* apply p N r)%vector).
  Proof.
    intros Positive Lower Falls x0 xhat0 Below.
    destruct (falling_solutions_exist (n + n) M lower level pair_flow Positive) with
      (e0 := pair_of n x0 (x0 - xhat0)%vector) as (z & Start & Z).
    - intros z. rewrite (form_ext (n + n) M M z (pair_of n z (second n z))); [|easy|].
      2: { intros i I. symmetry. apply pair_of_halves, I. }
      replace (square (n + n) z) with (square n z + square n (second n z)); [apply Lower|].
      unfold square. rewrite sum_split. reflexivity.
    - apply pair_flow_lipschitz.
    - intros z V.
      assert (H : forall i, (i < n + n)%nat -> z i = pair_of n z (second n z) i).
      { intros i I. symmetry. apply pair_of_halves, I. }
      rewrite (form_ext (n + n) M M z (pair_of n z (second n z)) (fun i j _ _ => eq_refl) H) in V.
      specialize (Falls z (second n z) V). cbv zeta in Falls. fold (pair_flow z) in Falls.
      rewrite (bilinear_ext (n + n) (n + n) M M (pair_flow z) z (pair_flow z) (pair_of n z (second n z)));
        [|easy|easy|exact H].
      rewrite (bilinear_ext (n + n) (n + n) M M z (pair_flow z) (pair_of n z (second n z)) (pair_flow z));
        [exact Falls|easy|exact H|easy].
    - exact Below.
    - set (e := fun t => second n (z t)). set (xhat := fun t => (z t - e t)%vector).
      assert (X : forall T, solution T n z (fun t => loop_flow A B K (z t) (e t))).
      { intros T i I. destruct (Z T i ltac:(lia)) as [Cont D]. split; [exact Cont|]. intros t Ht. specialize (D t Ht).
        unfold pair_flow in D. rewrite pair_first in D by exact I. exact D. }
      assert (E : forall T, solution T n e (fun t => cubic_error p A C L theta N (e t))).
      { intros T i I. destruct (Z T (n + i)%nat ltac:(lia)) as [Cont D]. split; [exact Cont|]. intros t Ht.
        specialize (D t Ht). unfold pair_flow in D. rewrite pair_second in D. exact D. }
      assert (Error : forall t, (z t - xhat t)%vector = e t).
      { intros t. apply functional_extensionality. intros i. unfold xhat, minus_vector. ring. }
      exists z, xhat. split.
      + intros i I. pose proof (Start i) as S1. pose proof (Start (n + i)%nat) as S2.
        rewrite pair_first in S1 by exact I. rewrite pair_second in S2. split; [exact S1|].
        unfold xhat, e, minus_vector in *. change (second n (z 0) i) with (z 0 (n + i)%nat). rewrite S1, S2. ring.
      + intros T. split.
        * apply (solution_ext T n z (fun t => loop_flow A B K (z t) (e t))); [|apply X].
          intros t i I. rewrite (plant_in_loop n m) by assumption. rewrite Error. reflexivity.
        * refine (solution_ext T n xhat (fun t i => loop_flow A B K (z t) (e t) i - cubic_error p A C L theta N (e t) i)
            _ _ (solution_difference T n z e _ _ (X T) (E T))).
          intros t i I. cbv beta.
          pose proof (error_in_loop n p A B C K L theta HA HC HL Htheta N (z t) (xhat t) i I) as D.
          pose proof (plant_in_loop n m A B K HB HK (z t) (xhat t) i I) as F. rewrite Error in D, F.
          cbv zeta in *. rewrite F in D. lra.
  Qed.
End Loop.

(** From every x(0) and xhat(0). *)
Theorem loops_exist n m p A B C K L P1 P theta a lower upper overshoot :
  loop_decays n m p A B C K L P1 P theta a lower upper overshoot = true -> Qle_bool 0 a = true ->
  forall N, dissipates n p C P N -> forall x0 xhat0 : vector, exists x xhat : R -> vector,
    (forall i, (i < n)%nat -> x 0 i = x0 i /\ xhat 0 i = xhat0 i) /\ forall T,
    solution T n x (fun t => A * x t - B * (K * xhat t))%vector
    /\ solution T n xhat (fun t => let r := (C * x t - C * xhat t)%vector in
         (A * xhat t - B * (K * xhat t) + L * r - quadratic p theta r .* apply p N r)%vector).
Proof.
  intros Checked Sign N Dissipates x0 xhat0. apply not_negative in Sign.
  destruct (loop_parts _ _ _ _ _ _ _ _ _ _ _ _ _ _ _ Checked)
    as (Between & Between1 & HA & HB & HC & HK & HL & Htheta & HP1 & HP).
  destruct (between_numbers _ _ _ _ _ Between) as (Positive & _ & _).
  assert (Lower : forall v w, Q2R lower * (square n v + square n w) <= form (n + n) (both_matrix n P1 P) (pair_of n v
    w)).
  { intros v w. rewrite pair_form, !quadratic_form by assumption.
    pose proof (between_lower _ _ _ _ _ Between1 v). pose proof (between_lower _ _ _ _ _ Between w). lra. }
  apply (loops_exist_below n m p A B C K L theta N HA HB HC HK HL Htheta (both_matrix n P1 P) (Q2R lower)
    (form (n + n) (both_matrix n P1 P) (pair_of n x0 (x0 - xhat0)%vector) + 1) Positive Lower); [|lra].
  intros v w _ f.
  pose proof (loop_flow_falls _ _ _ _ _ _ _ _ _ _ _ _ _ _ _ Checked N Dissipates v w) as D. cbv zeta in D. fold f in D.
  assert (0 <= form (n + n) (both_matrix n P1 P) (pair_of n v w)).
  { apply Rle_trans with (2 := Lower v w). apply Rmult_le_pos; [lra|].
    apply Rplus_le_le_0_compat; apply square_nonnegative. }
  assert (0 <= 2 * Q2R a * form (n + n) (both_matrix n P1 P) (pair_of n v w)) by (apply Rmult_le_pos; lra). lra.
Qed.
