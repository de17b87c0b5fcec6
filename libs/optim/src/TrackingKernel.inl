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

// Hessian of the value function: columns of the blocks over position p, velocity v and input
// before u, which are the state in front of a stage.
struct Value
{
  Pack pp[kAxes], pv[kAxes], vp[kAxes], vv[kAxes], pu[kAxes], vu[kAxes], uu[kAxes];
};

inline Pack unit(int axis, double length)
{
  Quad quad;
  quad.lane[axis] = length;
  return load(quad);
}

// The rows add weight n n^T, the lead couples position and velocity.
inline void addRows(const Node& node, const Rows* rows, Value& value)
{
  Pack near[kAxes][kAxes], led[kAxes][kAxes], twice[kAxes][kAxes];
  SLALOM_EACH(int i = 0; i < kAxes; ++i)
  SLALOM_EACH(int j = 0; j <= i; ++j) near[i][j] = led[i][j] = twice[i][j] = all(0.0);
  for (int g = 0; g < node.groups; ++g, ++rows)
  {
    const Pack weight = load(rows->weight), lead = load(rows->lead);
    SLALOM_EACH(int i = 0; i < kAxes; ++i)
    {
      const Pack one = weight * load(rows->normal[i]);
      SLALOM_EACH(int j = 0; j <= i; ++j)
      {
        const Pack square = one * load(rows->normal[j]);
        near[i][j] = near[i][j] + square;
        if (!node.leads) continue;
        led[i][j] = led[i][j] + square * lead;
        twice[i][j] = twice[i][j] + square * lead * lead;
      }
    }
  }
  const auto add = [](const Pack(&sums)[kAxes][kAxes], Pack(&block)[kAxes])
  {
    Quad columns[kAxes];
    SLALOM_EACH(int i = 0; i < kAxes; ++i)
    SLALOM_EACH(int j = 0; j <= i; ++j)
    columns[i].lane[j] = columns[j].lane[i] = total(sums[i][j]);
    SLALOM_EACH(int i = 0; i < kAxes; ++i) block[i] = block[i] + load(columns[i]);
  };
  add(near, value.pp);
  if (!node.leads) return;
  add(led, value.pv);
  add(led, value.vp);
  add(twice, value.vv);
}

// L D L^T of the symmetric matrix whose columns are given.
inline bool decompose(const Quad (&h)[kAxes], Node& node)
{
  bool positive = true;
  double diagonal[kAxes];
  SLALOM_EACH(int i = 0; i < kAxes; ++i)
  {
    SLALOM_EACH(int j = 0; j < i; ++j)
    {
      double entry = 0.5 * (h[i].lane[j] + h[j].lane[i]);
      SLALOM_EACH(int m = 0; m < j; ++m)
      entry -= node.lower[i].lane[m] * node.lower[j].lane[m] * diagonal[m];
      node.lower[i].lane[j] = entry * node.pivot.lane[j];
    }
    double entry = h[i].lane[i];
    SLALOM_EACH(int m = 0; m < i; ++m)
    entry -= node.lower[i].lane[m] * node.lower[i].lane[m] * diagonal[m];
    positive = positive && entry > 0.0;
    diagonal[i] = entry;
    node.pivot.lane[i] = 1.0 / entry;
  }
  return positive;
}

// block_j -= sum_i a_i (D^-1 b_i)_j
inline void subtract(const Quad (&a)[kAxes], const Quad (&scaled)[kAxes], Pack (&block)[kAxes],
                     bool triangular = false)
{
  SLALOM_EACH(int j = 0; j < kAxes; ++j)
  SLALOM_EACH(int i = 0; i < kAxes; ++i)
  if (!triangular || i >= j) block[j] = block[j] - load(a[i]) * all(scaled[i].lane[j]);
}

// The gap weights of a stage: of its input, and of its change.
struct LimitWeights
{
  Pack input, change;
};

inline LimitWeights limitWeights(const Node& node)
{
  const auto weight = [&](int i) { return load(node.force[i]) * load(node.inverse_gap[i]); };
  return {weight(0) + weight(1), weight(2) + weight(3)};
}

// Takes the input of the stage out of the value function behind it.
bool eliminate(Node& node, const Rows* rows, double damping, Value& value)
{
  const Pack p_u = all(node.p_u), v_u = all(node.v_u), p_v = all(node.p_v), v_v = all(node.v_v);
  SLALOM_EACH(int j = 0; j < kAxes; ++j)
  {
    value.pp[j] = value.pp[j] + load(node.position_weight[j]);
    value.vv[j] = value.vv[j] + unit(j, node.velocity_weight);
  }
  if (node.groups > 0) addRows(node, rows, value);
  const LimitWeights weights = limitWeights(node);
  Quad change, own;
  store(change, weights.change + all(node.change_weight));
  store(own, weights.input + all(node.input_weight + damping));
  Quad h[kAxes];
  Pack over_p[kAxes], over_v[kAxes];
  SLALOM_EACH(int j = 0; j < kAxes; ++j)
  {
    over_p[j] = p_u * value.pp[j] + v_u * value.pv[j] + value.pu[j];
    over_v[j] = p_u * value.vp[j] + v_u * value.vv[j] + value.vu[j];
    // Only its symmetric part counts.
    const Pack column = p_u * (over_p[j] + v_u * value.pv[j] + value.pu[j]) +
                        v_u * (v_u * value.vv[j] + value.vu[j] + value.vu[j]) + value.uu[j];
    store(h[j], column);
    h[j].lane[j] += own.lane[j] + change.lane[j];
  }
  if (!decompose(h, node)) return false;

  Quad scaled_p[kAxes], scaled_v[kAxes], scaled_u[kAxes];
  SLALOM_EACH(int i = 0; i < kAxes; ++i)
  {
    Pack p = over_p[i], v = p_v * over_p[i] + v_v * over_v[i], u = unit(i, -change.lane[i]);
    SLALOM_EACH(int m = 0; m < i; ++m)
    {
      const Pack factor = all(node.lower[i].lane[m]);
      p = p - factor * load(node.tied_p[m]);
      if (kLag) v = v - factor * load(node.tied_v[m]);
      u = u - factor * load(node.tied_u[m]);
    }
    const Pack pivot = all(node.pivot.lane[i]);
    store(node.tied_p[i], p);
    store(scaled_p[i], pivot * p);
    store(node.tied_u[i], u);
    store(scaled_u[i], pivot * u);
    if (!kLag) continue;
    store(node.tied_v[i], v);
    store(scaled_v[i], pivot * v);
  }
  SLALOM_EACH(int j = 0; j < kAxes; ++j)
  {
    value.pu[j] = value.vu[j] = all(0.0);
    value.uu[j] = unit(j, change.lane[j]);
    if (kLag)
    {
      const Pack pv = value.pv[j];
      value.pv[j] = p_v * value.pp[j] + v_v * pv;
      value.vv[j] = p_v * (value.pv[j] + v_v * value.vp[j]) + v_v * v_v * value.vv[j];
      value.vp[j] = p_v * value.pp[j] + v_v * value.vp[j];
    }
    else
      value.pv[j] = value.vp[j] = value.vv[j] = all(0.0);
  }
  subtract(node.tied_p, scaled_p, value.pp);
  subtract(node.tied_p, scaled_u, value.pu, true);
  subtract(node.tied_u, scaled_u, value.uu, true);
  if (!kLag) return true;
  subtract(node.tied_p, scaled_v, value.pv);
  subtract(node.tied_v, scaled_p, value.vp);
  subtract(node.tied_v, scaled_v, value.vv);
  subtract(node.tied_v, scaled_u, value.vu, true);
  return true;
}

bool factorize(Work& work)
{
  Value value;
  SLALOM_EACH(int j = 0; j < kAxes; ++j)
  value.pp[j] = value.pv[j] = value.vp[j] = value.vv[j] = value.pu[j] = value.vu[j] = value.uu[j] =
      all(0.0);
  const double damping = work.damping * work.scale;
  for (std::size_t k = work.nodes.size(); k-- > 0;)
    if (!eliminate(work.nodes[k], rowsOf(work, k), damping, value)) return false;
  return true;
}

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

#undef SLALOM_EACH
