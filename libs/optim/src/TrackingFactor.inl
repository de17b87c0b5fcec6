// SPDX-License-Identifier: BSD-3-Clause
// Part of TrackingKernel.inl: the Riccati recursion of the Newton matrix.

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
