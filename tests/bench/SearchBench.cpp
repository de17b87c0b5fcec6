// SPDX-License-Identifier: BSD-3-Clause
/** Guides through 16 x 16 x 8 m of map at 0.2 m, as the global planner asks for them: start and goal
 * 2 to 8 m apart, no straight way, box = both + 3 m around and 0.5 m up and down.
 *
 *  Every problem is searched several times; its time is the median of those. Counters, over the
 * problems: median, p99 and worst of these times [us], worst single call, and the same for a textbook
 * A* on the same lattice (std::priority_queue, Euclidean distance as bound, every edge checked), run
 * in turn with ours. */
#include <benchmark/benchmark.h>

#include <algorithm>
#include <chrono>
#include <functional>

#include "SearchProblems.h"
#include "TextbookAStar.h"
#include "slalom/search/GridSearch.h"

namespace
{
using namespace slalom;
using bench::SearchProblem;

struct Times
{
  std::vector<double> of_problem;  ///< [us] median of the calls
  double worst_call = 0.0;         ///< [us]

  [[nodiscard]] double quantile(double q)
  {
    std::sort(of_problem.begin(), of_problem.end());
    return of_problem[static_cast<std::size_t>(q * static_cast<double>(of_problem.size() - 1) +
                                               0.5)];
  }
};

template <class Search>
void time(Times& times, Search&& search, int calls)
{
  std::vector<double> took;
  for (int i = 0; i < calls; ++i)
  {
    const auto begin = std::chrono::steady_clock::now();
    search();
    took.push_back(
        std::chrono::duration<double, std::micro>(std::chrono::steady_clock::now() - begin)
            .count());
  }
  std::sort(took.begin(), took.end());
  times.of_problem.push_back(took[took.size() / 2]);
  times.worst_call = std::max(times.worst_call, took.back());
}

void report(benchmark::State& state, const std::vector<SearchProblem>& problems)
{
  const search::GridSearchConfig config;
  Times one, textbook;
  double expansions = 0.0, longer = 0.0, found = 0.0;
  for (auto _ : state)
    for (const SearchProblem& p : problems)
    {
      search::SearchResult result;
      const auto ours = [&]
      { result = search::findPath(*p.field, p.start_L, p.goal_L, p.box_L, config); };
      time(one, ours, 5);
      bench::TextbookResult plain;
      time(
          textbook, [&]
          { plain = bench::textbookAStar(*p.field, p.start_L, p.goal_L, p.box_L, config); }, 1);
      expansions += result.expansions;
      if (result.status != search::SearchStatus::Found) continue;
      longer += result.length_m / plain.length_m;
      ++found;
    }
  state.counters["median_us"] = one.quantile(0.5);
  state.counters["p99_us"] = one.quantile(0.99);
  state.counters["worst_us"] = one.quantile(1.0);
  state.counters["worst_call_us"] = one.worst_call;
  state.counters["textbook_median_us"] = textbook.quantile(0.5);
  state.counters["textbook_p99_us"] = textbook.quantile(0.99);
  state.counters["textbook_by_ours"] = textbook.quantile(0.5) / one.quantile(0.5);
  state.counters["expansions"] = expansions / static_cast<double>(one.of_problem.size());
  state.counters["found"] = found / static_cast<double>(one.of_problem.size());
  if (found > 0.0) state.counters["length_by_textbook"] = longer / found;
}

void add(const char* name, const std::function<std::vector<SearchProblem>()>& make)
{
  benchmark::RegisterBenchmark(
      name, [make](benchmark::State& state) { report(state, make()); })
      ->Iterations(1)
      ->Unit(benchmark::kMillisecond);
}

const bool registered = []
{
  add("forest/0.1", [] { return bench::forests(0.1, 200); });
  add("forest/0.2", [] { return bench::forests(0.2, 200); });
  add("forest/0.3", [] { return bench::forests(0.3, 200); });
  add("crowns/0.2", [] { return bench::crowns(0.2, 200); });
  add("u_trap", [] { return bench::uTraps(50); });
  add("two_gaps", [] { return bench::twoGaps(50); });
  add("unreachable", [] { return bench::unreachable(100); });
  add("tall_forest/0.2", [] { return bench::tall(bench::forests(0.2, 50)); });
  return true;
}();
}  // namespace
