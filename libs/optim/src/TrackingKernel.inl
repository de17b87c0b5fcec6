// SPDX-License-Identifier: BSD-3-Clause
// The steps of the interior point along the stages. TrackingSteps.cpp includes this file once per
// instruction set, number of axes (SLALOM_AXES) and kind of vehicle (SLALOM_LAG), each inside a
// namespace of its own. No contraction of a*b+c takes place, so all sets give the same bits.
//
// Without a lag the velocity is no state: every block of the value function that has to do with the
// velocity before a stage is zero and is left out.

constexpr int kAxes = SLALOM_AXES;
constexpr bool kLag = SLALOM_LAG;
using Node = TrackingNode<kAxes>;
using Rows = RowGroup<kAxes>;
using Work = TrackingWork<kAxes>;

#define SLALOM_EACH _Pragma("GCC unroll 4") for

inline Rows* rowsOf(Work& work, std::size_t k)
{
  return work.rows.data() + k * static_cast<std::size_t>(work.max_groups);
}
inline const Rows* rowsOf(const Work& work, std::size_t k)
{
  return work.rows.data() + k * static_cast<std::size_t>(work.max_groups);
}

inline Pack difference(const Quad& a, const Quad& b)
{
  return load(a) - load(b);
}

// Columns of the position weight times a vector.
inline Pack weighted(const Node& node, const Pack& x)
{
  Quad at;
  store(at, x);
  Pack sum = all(0.0);
  SLALOM_EACH(int j = 0; j < kAxes; ++j)
  sum = sum + load(node.position_weight[j]) * all(at.lane[j]);
  return sum;
}

// normal . (p + lead v) of four rows.
inline Pack along(const Rows& rows, bool leads, const Quad& p, const Quad& v)
{
  Pack sum = all(0.0), ahead = all(0.0);
  SLALOM_EACH(int j = 0; j < kAxes; ++j)
  sum = sum + load(rows.normal[j]) * all(p.lane[j]);
  if (!leads) return sum;
  SLALOM_EACH(int j = 0; j < kAxes; ++j)
  ahead = ahead + load(rows.normal[j]) * all(v.lane[j]);
  return sum + load(rows.lead) * ahead;
}

void rollOut(Work& work)
{
  Pack p = load(work.p), v = load(work.v);
  for (Node& node : work.nodes)
  {
    const Pack u = load(node.u);
    Pack next_p = all(node.p_u) * u + p, next_v = all(node.v_u) * u;
    if (kLag)
    {
      next_p = next_p + all(node.p_v) * v;
      next_v = next_v + all(node.v_v) * v;
    }
    p = next_p + load(node.drift_p);
    v = next_v + load(node.drift_v);
    store(node.p, p);
    store(node.v, v);
  }
}

void gaps(const Node& node, const Quad& before, Pack (&gap)[4])
{
  const Pack change = difference(node.u, before), limit = load(node.change_limit);
  gap[0] = difference(node.u, node.low);
  gap[1] = difference(node.high, node.u);
  gap[2] = limit + change;
  gap[3] = limit - change;
}

// On the central path force (t + slack) = (penalty - force) slack = mu, which is a quadratic
// equation for the smaller of the two multipliers.
void centreRows(Rows& rows, const Pack& t, double mu)
{
  const Pack penalty = load(rows.penalty), far = absolute(t), wide = all(2.0 * mu);
  const Pack reach = far * penalty;
  const Pack small = wide * penalty / (reach + wide + root(reach * reach + wide * wide));
  const Pack other = penalty - small;
  const Pack near = all(mu) / other, away = near + far;
  store(rows.force, where(t, small, other));
  store(rows.above, where(t, away, near));
  store(rows.slack, where(t, near, away));
}

void centre(Work& work, double mu)
{
  const Quad* before = &work.u_before;
  for (std::size_t k = 0; k < work.nodes.size(); ++k)
  {
    Node& node = work.nodes[k];
    Pack gap[4];
    gaps(node, *before, gap);
    SLALOM_EACH(int i = 0; i < 4; ++i)
    store(node.force[i], all(mu) / gap[i]);
    before = &node.u;
    Rows* rows = rowsOf(work, k);
    for (int g = 0; g < node.groups; ++g, ++rows)
      centreRows(*rows, along(*rows, node.leads, node.p, node.v) - load(rows->offset), mu);
  }
}

void measureCost(Node& node, const Quad& before, Pack& largest)
{
  const Pack p = weighted(node, difference(node.p, node.position));
  const Pack v = all(node.velocity_weight) * difference(node.v, node.velocity);
  const Pack u = all(node.input_weight) * difference(node.u, node.input);
  const Pack e = all(node.change_weight) * (difference(node.u, before) - load(node.change));
  store(node.grad_p, p);
  store(node.grad_v, v);
  store(node.grad_u, u);
  store(node.grad_e, e);
  largest =
      higher(largest, higher(higher(absolute(p), absolute(v)), higher(absolute(u), absolute(e))));
}

void measure(Work& work)
{
  Pack largest = all(0.0), sum = all(0.0), product = all(0.0);
  const auto pair = [&](const Pack& a, const Pack& b)
  {
    const Pack one = a * b;
    sum = sum + one;
    product = higher(product, one);
    return one;
  };
  const Quad* before = &work.u_before;
  for (std::size_t k = 0; k < work.nodes.size(); ++k)
  {
    Node& node = work.nodes[k];
    measureCost(node, *before, largest);
    Pack gap[4];
    gaps(node, *before, gap);
    SLALOM_EACH(int i = 0; i < 4; ++i)
    {
      const Pack inside = higher(gap[i], all(1e-15)), force = load(node.force[i]);
      const Pack inverse = all(1.0) / pair(inside, force);
      store(node.gap[i], inside);
      store(node.inverse_gap[i], inverse * force);
      store(node.inverse_force[i], inverse * inside);
    }
    before = &node.u;
    Rows* rows = rowsOf(work, k);
    for (int g = 0; g < node.groups; ++g, ++rows)
    {
      // The larger of the two is the sum of the smaller and the distance: no digits are lost.
      const Pack t = along(*rows, node.leads, node.p, node.v) - load(rows->offset);
      const Pack above = where(t, t + load(rows->slack), load(rows->above));
      const Pack slack = where(t, load(rows->slack), load(rows->above) - t);
      store(rows->above, above);
      store(rows->slack, slack);
      const Pack force = load(rows->force), rest = load(rows->penalty) - force;
      pair(above, force);
      pair(slack, rest);
      const Pack inverse = all(1.0) / (rest * above + force * slack);
      store(rows->inverse, inverse);
      store(rows->weight, force * rest * inverse);
    }
  }
  work.mu = total(sum) / work.pairs;
  work.product = top(product);
  work.scale = 1.0 + top(largest);
}

// What a Newton step asks of the products of its pairs: gap times force -> centre, minus `second`
// times the second-order term of the direction before. The predictor asks for zero.
struct Aim
{
  double centre = 0.0, second = 0.0;
};

struct RowAim
{
  Pack above, slack;
};

inline RowAim rowAim(const Rows& rows, const Aim& aim)
{
  const Pack force = load(rows.force), rest = load(rows.penalty) - force;
  RowAim residual{all(0.0) - load(rows.above) * force, all(0.0) - load(rows.slack) * rest};
  if (aim.centre == 0.0) return residual;
  const Pack step = all(aim.second) * load(rows.d_force), centre = all(aim.centre);
  residual.above = residual.above + centre - load(rows.d_above) * step;
  residual.slack = residual.slack + centre + load(rows.d_slack) * step;
  return residual;
}

// The part of (force + its step) that does not depend on the step of the inputs.
inline Pack constantForce(const Rows& rows, const RowAim& residual)
{
  const Pack force = load(rows.force), rest = load(rows.penalty) - force;
  return force + (rest * residual.above - force * residual.slack) * load(rows.inverse);
}

// The pull of the rows of a stage on its position and velocity.
struct RowSum
{
  Pack p = all(0.0), v = all(0.0);
};

// With the forces as they are, or, given an aim, with the constant part of the next ones.
inline RowSum pull(const Rows* rows, const Node& node, const Aim* aim)
{
  RowSum sum;
  if (node.groups == 0) return sum;
  Pack near[kAxes], ahead[kAxes];
  SLALOM_EACH(int i = 0; i < kAxes; ++i) near[i] = ahead[i] = all(0.0);
  for (int g = 0; g < node.groups; ++g, ++rows)
  {
    const Pack one = aim ? constantForce(*rows, rowAim(*rows, *aim)) : load(rows->force);
    SLALOM_EACH(int i = 0; i < kAxes; ++i) near[i] = near[i] + load(rows->normal[i]) * one;
    if (!node.leads) continue;
    const Pack led = one * load(rows->lead);
    SLALOM_EACH(int i = 0; i < kAxes; ++i) ahead[i] = ahead[i] + load(rows->normal[i]) * led;
  }
  Quad p, v;
  SLALOM_EACH(int i = 0; i < kAxes; ++i) p.lane[i] = total(near[i]);
  sum.p = load(p);
  if (!node.leads) return sum;
  SLALOM_EACH(int i = 0; i < kAxes; ++i) v.lane[i] = total(ahead[i]);
  sum.v = load(v);
  return sum;
}

double dualResidual(const Work& work)
{
  Pack p = all(0.0), v = all(0.0), e = all(0.0), largest = all(0.0);
  for (std::size_t k = work.nodes.size(); k-- > 0;)
  {
    const Node& node = work.nodes[k];
    const RowSum sum = pull(rowsOf(work, k), node, nullptr);
    p = p + load(node.grad_p) - sum.p;
    v = v + load(node.grad_v) - sum.v;
    const Pack own = load(node.grad_e) - load(node.force[2]) + load(node.force[3]);
    const Pack u = all(node.p_u) * p + all(node.v_u) * v + load(node.grad_u) - load(node.force[0]) +
                   load(node.force[1]) + own - e;
    largest = higher(largest, absolute(u));
    v = all(node.p_v) * p + all(node.v_v) * v;
    e = own;
  }
  return top(largest);
}

#include "TrackingDirection.inl"

#undef SLALOM_EACH
