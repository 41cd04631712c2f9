(** From an inequality for the derivative to one for the function.

    A solution is differentiable for [0 < t < T] and continuous at 0 from the right: nothing is assumed of times before
    0. T is arbitrary, so that a solution for all times is covered by all T. *)

From Coq Require Import Reals List Lra Lia.
From Luenberger Require Import Vectors.
Import ListNotations.
Local Open Scope R_scope.

Definition right_continuous_at_0 (f : R -> R) : Prop :=
  forall eps, 0 < eps -> exists delta, 0 < delta /\ forall t, 0 <= t < delta -> Rabs (f t - f 0) < eps.

(** [x' = f] on (0, T) for the first n entries of [x t] and [f t]: [derivable_pt_lim g t d] of Coq's library says that
    g has the derivative d at t. *)
Definition solution (T : R) (n : nat) (x f : R -> vector) : Prop :=
  forall i, (i < n)%nat ->
    right_continuous_at_0 (fun t => x t i) /\ forall t, 0 < t < T -> derivable_pt_lim (fun s => x s i) t (f t i).

(** ** Continuity *)

Lemma right_continuous_limit f : right_continuous_at_0 f <-> limit1_in f (fun t => 0 <= t) (f 0) 0.
Proof.
  split; intros H eps He; destruct (H eps He) as (d & Hd & K); exists d; split; try exact Hd.
  - intros t [Ht B]. simpl in *. unfold R_dist in *. apply K. rewrite Rminus_0_r, Rabs_pos_eq in B by exact Ht. lra.
  - intros t Ht. apply (K t). split; [lra|]. simpl. unfold R_dist. rewrite Rminus_0_r, Rabs_pos_eq; lra.
Qed.

Lemma right_continuous_const c : right_continuous_at_0 (fun _ => c).
Proof. intros eps He. exists 1. split; [lra|]. intros. rewrite Rminus_diag_eq, Rabs_R0; trivial. Qed.

Lemma right_continuous_plus f g :
  right_continuous_at_0 f -> right_continuous_at_0 g -> right_continuous_at_0 (fun t => f t + g t).
Proof. rewrite !right_continuous_limit. intros F G. exact (limit_plus f g _ _ _ _ F G). Qed.

Lemma right_continuous_minus f g :
  right_continuous_at_0 f -> right_continuous_at_0 g -> right_continuous_at_0 (fun t => f t - g t).
Proof. rewrite !right_continuous_limit. intros F G. exact (limit_minus f g _ _ _ _ F G). Qed.

Lemma right_continuous_mult f g :
  right_continuous_at_0 f -> right_continuous_at_0 g -> right_continuous_at_0 (fun t => f t * g t).
Proof. rewrite !right_continuous_limit. intros F G. exact (limit_mul f g _ _ _ _ F G). Qed.

Lemma right_continuous_sum n (f : R -> nat -> R) :
  (forall i, (i < n)%nat -> right_continuous_at_0 (fun t => f t i)) -> right_continuous_at_0 (fun t => sum n (f t)).
Proof.
  induction n as [|n IH]; intros H.
  - exact (right_continuous_const 0).
  - apply (right_continuous_plus (fun t => sum n (f t)) (fun t => f t n)); [apply IH; intros; apply H; lia|apply H;
    lia].
Qed.

Lemma right_continuous_derivable f d : derivable_pt_lim f 0 d -> right_continuous_at_0 f.
Proof.
  intros D eps He.
  assert (C : continuity_pt f 0) by (apply derivable_continuous_pt; exists d; exact D).
  destruct (C eps He) as (delta & Hd & K). exists delta. split; [exact Hd|]. intros t Ht.
  destruct (Req_dec t 0) as [->|N].
  - rewrite Rminus_diag_eq, Rabs_R0; trivial.
  - apply (K t). split; [split; [exact I|congruence]|]. simpl. unfold R_dist. rewrite Rminus_0_r, Rabs_pos_eq; lra.
Qed.

(** ** Derivatives *)

Lemma derivative_sum n (f : R -> nat -> R) t (d : nat -> R) :
  (forall i, (i < n)%nat -> derivable_pt_lim (fun s => f s i) t (d i)) -> derivable_pt_lim (fun s => sum n (f s))
    t (sum n d).
Proof.
  induction n as [|n IH]; intros H.
  - exact (derivable_pt_lim_const 0 t).
  - exact (derivable_pt_lim_plus (fun s => sum n (f s)) (fun s => f s n) t _ _ (IH (fun i L => H i ltac:(lia)))
    (H n ltac:(lia))).
Qed.

Lemma derivative_form n P (x : R -> vector) t (d : vector) :
  (forall i, (i < n)%nat -> derivable_pt_lim (fun s => x s i) t (d i)) ->
  derivable_pt_lim (fun s => form n P (x s)) t (bilinear n n P d (x t) + bilinear n n P (x t) d).
Proof.
  intros H. unfold form, bilinear. rewrite <- sum_plus.
  apply derivative_sum with (f := fun s i => x s i * apply n P (x s) i). intros i I.
  apply (derivable_pt_lim_mult (fun s => x s i) (fun s => apply n P (x s) i)); [apply H; exact I|].
  apply derivative_sum with (f := fun s j => P i j * x s j). intros j J.
  apply (derivable_pt_lim_scal (fun s => x s j)). apply H. exact J.
Qed.

Lemma right_continuous_form n P (x : R -> vector) :
  (forall i, (i < n)%nat -> right_continuous_at_0 (fun t => x t i)) -> right_continuous_at_0 (fun t => form n P (x t)).
Proof.
  intros H. apply right_continuous_sum with (f := fun t i => x t i * apply n P (x t) i). intros i I.
  apply (right_continuous_mult (fun t => x t i)); [apply H; exact I|].
  apply right_continuous_sum with (f := fun t j => P i j * x t j). intros j J.
  apply (right_continuous_mult (fun _ => P i j)); [apply right_continuous_const|apply H; exact J].
Qed.

Lemma derivative_exponential c t : derivable_pt_lim (fun s => exp (c * s)) t (c * exp (c * t)).
Proof.
  rewrite Rmult_comm. apply (derivable_pt_lim_comp (fun s => c * s) exp).
  - pose proof (derivable_pt_lim_scal id c t 1 (derivable_pt_lim_id t)) as D. rewrite Rmult_1_r in D. exact D.
  - apply derivable_pt_lim_exp.
Qed.

(** ** Comparison *)

(** A function with a derivative of at most 0 does not grow. *)
Lemma decreasing T f d :
  right_continuous_at_0 f -> (forall t, 0 < t < T -> derivable_pt_lim f t (d t)) -> (forall t, 0 < t < T -> d t <= 0) ->
  forall s t, 0 <= s -> s <= t -> t < T -> f t <= f s.
Proof.
  intros C D N.
  assert (Inner : forall s t, 0 < s -> s <= t -> t < T -> f t <= f s).
  { intros s t Hs L Ht. destruct (Req_dec s t) as [->|E]; [lra|].
    destruct (MVT_cor2 f d s t) as (c & K & Hc); [lra| |].
    - intros c Hc. apply D. lra.
    - assert (d c <= 0) by (apply N; lra). nra. }
  intros s t Hs L Ht. destruct (Req_dec s 0) as [->|E]; [|apply Inner; lra].
  destruct (Req_dec t 0) as [->|E]; [lra|].
  apply Rnot_lt_le. intros A. destruct (C (f t - f 0)) as (delta & Hd & K); [lra|].
  set (r := Rmin (t / 2) (delta / 2)).
  assert (0 < r) by (unfold r; apply Rmin_glb_lt; lra).
  assert (r <= t / 2) by apply Rmin_l. assert (r <= delta / 2) by apply Rmin_r.
  assert (f t <= f r) by (apply Inner; lra).
  assert (B : Rabs (f r - f 0) < f t - f 0) by (apply K; lra). apply Rabs_def2 in B. lra.
Qed.

(** [V' <= -2 a V] implies [V(t) <= exp(-2 a t) V(0)], since [exp(2 a t) V(t)] does not grow. *)
Lemma exponential_decay T a V d :
  right_continuous_at_0 V -> (forall t, 0 < t < T -> derivable_pt_lim V t (d t)) ->
  (forall t, 0 < t < T -> d t <= - (2 * a) * V t) ->
  forall t, 0 <= t < T -> V t <= exp (- (2 * a) * t) * V 0.
Proof.
  intros C D N t Ht. set (b := 2 * a) in *.
  assert (K : exp (b * t) * V t <= exp (b * 0) * V 0).
  { apply (decreasing T (fun t => exp (b * t) * V t) (fun t => b * exp (b * t) * V t + exp (b * t) * d t)); try lra.
    - apply right_continuous_mult; [|exact C]. apply (right_continuous_derivable _ _ (derivative_exponential b 0)).
    - intros r Hr. apply (derivable_pt_lim_mult (fun t => exp (b * t)) V); [apply derivative_exponential|apply D;
      exact Hr].
    - intros r Hr. specialize (N r Hr). pose proof (exp_pos (b * r)).
      replace (b * exp (b * r) * V r + exp (b * r) * d r) with (exp (b * r) * (d r - - b * V r)) by ring.
      assert (d r - - b * V r <= 0) by lra. nra. }
  rewrite Rmult_0_r, exp_0, Rmult_1_l in K.
  assert (E : exp (- b * t) * exp (b * t) = 1) by (rewrite <- exp_plus; replace (- b * t + b * t) with 0 by ring;
    apply exp_0).
  replace (V t) with (exp (- b * t) * (exp (b * t) * V t)) by (rewrite <- Rmult_assoc, E; ring).
  apply Rmult_le_compat_l; [apply Rlt_le, exp_pos|exact K].
Qed.
