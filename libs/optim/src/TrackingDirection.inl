// SPDX-License-Identifier: BSD-3-Clause
// Part of TrackingKernel.inl: predictor, corrector and move with the factors of TrackingFactor.inl.
#include "TrackingFactor.inl"

// The part of (force + its step) that does not depend on the step of the inputs.
inline Pack constantForce(const Node& node, int i, const Pack& d_gap, const Aim& aim)
{
  if (aim.centre == 0.0) return all(0.0);
  return (all(aim.centre) - all(aim.second) * d_gap * load(node.d_force[i])) *
         load(node.inverse_gap[i]);
}

// Gradient of the value function along the stages, from the last to the first.
void backward(Work& work, const Aim& aim)
{
  Pack p = all(0.0), v = all(0.0), u = all(0.0);
  for (std::size_t k = work.nodes.size(); k-- > 0;)
  {
    Node& node = work.nodes[k];
    const RowSum sum = pull(rowsOf(work, k), node, &aim);
    p = p + load(node.grad_p) - sum.p;
    v = v + load(node.grad_v) - sum.v;
    Pack change = load(node.grad_e), own = load(node.grad_u);
    if (aim.centre > 0.0)
    {
      const Pack du = load(node.du);
      const Pack de = k == 0 ? du : du - load(work.nodes[k - 1].du);
      own = own - constantForce(node, 0, du, aim) + constantForce(node, 1, all(0.0) - du, aim);
      change =
          change - constantForce(node, 2, de, aim) + constantForce(node, 3, all(0.0) - de, aim);
    }
    Quad h;
    store(h, all(node.p_u) * p + all(node.v_u) * v + u + own + change);
    v = kLag ? all(node.p_v) * p + all(node.v_v) * v : all(0.0);
    u = all(0.0) - change;
    SLALOM_EACH(int i = 0; i < kAxes; ++i)
    {
      SLALOM_EACH(int m = 0; m < i; ++m) h.lane[i] -= node.lower[i].lane[m] * h.lane[m];
      const double feed = h.lane[i] * node.pivot.lane[i];
      node.feed.lane[i] = feed;
      p = p - load(node.tied_p[i]) * all(feed);
      if (kLag) v = v - load(node.tied_v[i]) * all(feed);
      u = u - load(node.tied_u[i]) * all(feed);
    }
  }
}

// What is known of a direction before the move.
struct Reach
{
  Pack steepest = all(0.0);                   // largest relative loss of a gap or a force
  Pack linear = all(0.0), square = all(0.0);  // of the sum of products
};

inline void look(Reach& reach, const Pack& gap, const Pack& force, const Pack& d_gap,
                 const Pack& d_force, const Pack& inverse_gap, const Pack& inverse_force)
{
  const Pack none = all(0.0);
  reach.steepest =
      higher(reach.steepest, higher(none - d_gap * inverse_gap, none - d_force * inverse_force));
  reach.linear = reach.linear + (gap * d_force + force * d_gap);
  reach.square = reach.square + d_gap * d_force;
}

inline void moveRows(Rows& rows, const Pack& d_value, const Aim& aim, Reach& reach)
{
  const RowAim residual = rowAim(rows, aim);
  const Pack force = load(rows.force), rest = load(rows.penalty) - force;
  const Pack above = load(rows.above), slack = load(rows.slack);
  const Pack d_force = constantForce(rows, residual) - force - load(rows.weight) * d_value;
  const Pack d_slack =
      (slack * (residual.above - force * d_value) + above * residual.slack) * load(rows.inverse);
  const Pack d_above = d_value + d_slack;
  store(rows.d_value, d_value);
  store(rows.d_force, d_force);
  store(rows.d_slack, d_slack);
  store(rows.d_above, d_above);
  const Pack first = above * force, second = slack * rest, inverse = all(1.0) / (first * second);
  look(reach, above, force, d_above, d_force, inverse * second * force, inverse * second * above);
  look(reach, slack, rest, d_slack, all(0.0) - d_force, inverse * first * rest,
       inverse * first * slack);
}

// The limits of one stage in a direction.
inline void moveLimits(Node& node, const Pack& du, const Pack& de, const Pack& was_u,
                       const Pack& was_e, const Aim& aim, Reach& reach)
{
  SLALOM_EACH(int i = 0; i < 4; ++i)
  {
    const Pack sign = all(i % 2 == 0 ? 1.0 : -1.0);
    const Pack d_gap = sign * (i < 2 ? du : de), was = sign * (i < 2 ? was_u : was_e);
    const Pack gap = load(node.gap[i]), force = load(node.force[i]);
    const Pack inverse_gap = load(node.inverse_gap[i]);
    const Pack d_force = constantForce(node, i, was, aim) - force - force * inverse_gap * d_gap;
    store(node.d_force[i], d_force);
    look(reach, gap, force, d_gap, d_force, inverse_gap, load(node.inverse_force[i]));
  }
}

inline Pack inputStep(const Node& node, const Pack& dp, const Pack& dv, const Pack& du_before)
{
  Quad step;
  SLALOM_EACH(int i = kAxes - 1; i >= 0; --i)
  {
    Pack sum = load(node.tied_p[i]) * dp + load(node.tied_u[i]) * du_before;
    if (kLag) sum = sum + load(node.tied_v[i]) * dv;
    double a = 0.0 - node.feed.lane[i] - node.pivot.lane[i] * total(sum);
    SLALOM_EACH(int m = i + 1; m < kAxes; ++m) a -= node.lower[m].lane[i] * step.lane[m];
    step.lane[i] = a;
  }
  return load(step);
}

Reach forward(Work& work, const Aim& aim)
{
  Reach reach;
  Pack dp = all(0.0), dv = all(0.0), du_before = all(0.0), was_before = all(0.0);
  for (std::size_t k = 0; k < work.nodes.size(); ++k)
  {
    Node& node = work.nodes[k];
    const Pack du = inputStep(node, dp, dv, du_before), was = load(node.du);
    moveLimits(node, du, du - du_before, was, was - was_before, aim, reach);
    was_before = was;
    du_before = du;
    Pack next_p = dp + all(node.p_u) * du, next_v = all(node.v_u) * du;
    if (kLag)
    {
      next_p = next_p + all(node.p_v) * dv;
      next_v = next_v + all(node.v_v) * dv;
    }
    dp = next_p;
    dv = next_v;
    store(node.du, du);
    store(node.dp, dp);
    store(node.dv, dv);
    Rows* rows = rowsOf(work, k);
    for (int g = 0; g < node.groups; ++g, ++rows)
      moveRows(*rows, along(*rows, node.leads, node.dp, node.dv), aim, reach);
  }
  return reach;
}

void move(Work& work, double length)
{
  const Pack by = all(length);
  const auto add = [&](Quad& to, const Quad& step) { store(to, load(to) + by * load(step)); };
  for (std::size_t k = 0; k < work.nodes.size(); ++k)
  {
    Node& node = work.nodes[k];
    add(node.u, node.du);
    SLALOM_EACH(int i = 0; i < 4; ++i) add(node.force[i], node.d_force[i]);
    Rows* rows = rowsOf(work, k);
    for (int g = 0; g < node.groups; ++g, ++rows)
    {
      add(rows->above, rows->d_above);
      add(rows->slack, rows->d_slack);
      add(rows->force, rows->d_force);
    }
  }
  rollOut(work);
}

bool step(Work& work)
{
  if (!factorize(work)) return false;
  backward(work, {});
  const Reach predicted = forward(work, {});
  const double affine = 1.0 / std::max(1.0, top(predicted.steepest));
  const double after =
      work.mu + affine * (total(predicted.linear) + affine * total(predicted.square)) / work.pairs;
  const double ratio = std::max(0.0, after / work.mu);
  // The second-order term counts as far as the predictor reaches: in full it can lead the iterates
  // round in circles. The cautious do without.
  const double centre = std::max(work.cautious ? 0.3 : 1e-12, ratio * ratio * ratio);
  const Aim aim{centre * work.mu, work.cautious ? 0.0 : affine};
  backward(work, aim);
  const Reach reach = forward(work, aim);
  if (!std::isfinite(total(reach.linear) + total(reach.square))) return false;
  // Closer to the boundary the nearer the end is.
  const double fraction = work.cautious ? 0.8 : std::max(0.995, 1.0 - work.mu);
  const double loss = top(reach.steepest);
  const double length = loss <= fraction ? 1.0 : fraction / loss;
  if (!(length > 1e-9)) return false;
  move(work, length);
  return true;
}

constexpr TrackingSteps<kAxes> kSteps{&rollOut, &centre, &measure, &dualResidual, &step};
