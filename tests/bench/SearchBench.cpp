// SPDX-License-Identifier: BSD-3-Clause
/** Guides through 16 x 16 x 8 m of map at 0.2 m, as the global planner asks for them: start and
 * goal 2 to 8 m apart, no straight way, box = both + 3 m around and 0.5 m up and down.
 *
 *  Times are of the thread's own clock, so that other programs count less. Every problem is
 * searched several times; its time is the median of those. Counters, over the problems, in
 * microseconds: median and p99 of one path (`one_`), of up to three (`three_`) and of a textbook A*
 * on the same lattice (`textbook_`: std::priority_queue, Euclidean distance as bound, every edge
 * checked), run in turn; `worst_call` of any single call; how many paths there were, and how much
 * dearer than the first the second and third are. */
#include <benchmark/benchmark.h>

#include <algorithm>
#include <ctime>
#include <functional>
#include <string>

#include "SearchProblems.h"
#include "TextbookAStar.h"
#include "slalom/search/DistinctPaths.h"

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

double microseconds()
{
  timespec now;
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return 1e6 * static_cast<double>(now.tv_sec) + 1e-3 * static_cast<double>(now.tv_nsec);
}

template <class Search>
void time(Times& times, int calls, Search&& search)
{
  std::vector<double> took;
  for (int i = 0; i < calls; ++i)
  {
    const double begin = microseconds();
    search();
    took.push_back(microseconds() - begin);
  }
  std::sort(took.begin(), took.end());
  times.of_problem.push_back(took[took.size() / 2]);
  times.worst_call = std::max(times.worst_call, took.back());
}

struct Mean
{
  double sum = 0.0, count = 0.0;
  void add(double value)
  {
    sum += value;
    ++count;
  }
  [[nodiscard]] double value() const { return count > 0.0 ? sum / count : 0.0; }
};

void report(benchmark::State& state, const std::vector<SearchProblem>& problems)
{
  const search::GridSearchConfig config;
  Times one, three, textbook;
  Mean expansions, paths, longer, second, third;
  for (auto _ : state)
    for (const SearchProblem& p : problems)
    {
      std::vector<search::SearchResult> found(1);
      bench::TextbookResult plain;
      time(one, 5,
           [&] { found[0] = search::findPath(*p.field, p.start_L, p.goal_L, p.box_L, config); });
      expansions.add(found[0].expansions);
      time(three, 5,
           [&] {
             found = search::findDistinctPaths(*p.field, p.start_L, p.goal_L, p.box_L, config, 3);
           });
      time(textbook, 1,
           [&] { plain = bench::textbookAStar(*p.field, p.start_L, p.goal_L, p.box_L, config); });
      paths.add(found[0].status == search::SearchStatus::Found ? double(found.size()) : 0.0);
      if (plain.found) longer.add(found[0].cost_m / plain.cost);
      if (found.size() > 1) second.add(found[1].cost_m / found[0].cost_m);
      if (found.size() > 2) third.add(found[2].cost_m / found[0].cost_m);
    }
  for (const auto& [name, times] :
       {std::pair<std::string, Times*>("one", &one), {"three", &three}, {"textbook", &textbook}})
  {
    state.counters[name + "_median"] = times->quantile(0.5);
    state.counters[name + "_p99"] = times->quantile(0.99);
    state.counters[name + "_worst_call"] = times->worst_call;
  }
  state.counters["textbook_by_one"] = textbook.quantile(0.5) / one.quantile(0.5);
  state.counters["expansions"] = expansions.value();
  state.counters["paths"] = paths.value();
  state.counters["cost_by_textbook"] = longer.value();
  state.counters["second_by_first"] = second.value();
  state.counters["third_by_first"] = third.value();
}

void add(const char* name, const std::function<std::vector<SearchProblem>()>& make)
{
  benchmark::RegisterBenchmark(name, [make](benchmark::State& state) { report(state, make()); })
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
