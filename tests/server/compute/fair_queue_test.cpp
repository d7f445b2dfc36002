#include "server/compute/fair_queue.h"

#include <doctest/doctest.h>

#include <cstdint>
#include <deque>
#include <map>
#include <string>

using geodesic::server::FairQueue;

TEST_CASE("clients take turns, and each client's items stay in order") {
  FairQueue<std::string> queue;
  for (const char* item : {"a1", "a2", "a3", "a4"}) queue.push("a", item);
  for (const char* item : {"b1", "b2"}) queue.push("b", item);
  queue.push("c", "c1");
  CHECK(queue.size() == 7);
  CHECK(queue.clients() == 3);
  for (const char* item : {"a1", "b1", "c1", "a2", "b2", "a3", "a4"}) CHECK(queue.pop() == item);
  CHECK(queue.empty());
  CHECK(queue.clients() == 0);
}

TEST_CASE("a newcomer waits one turn of each client, however long their lines") {
  FairQueue<int> queue;
  for (int i = 0; i < 1000; ++i) queue.push("greedy", i);
  for (int i = 0; i < 10; ++i) queue.push("other", i);
  CHECK(queue.turns_before("new") == 2);
  CHECK(queue.turns_before("other") == 21);
  CHECK(queue.turns_before("greedy") == 1010);
  queue.push("new", -1);
  int pops = 1;
  while (queue.pop() != -1) ++pops;
  CHECK(pops == 3);
}

TEST_CASE("the longest line gives its newest item") {
  FairQueue<int> queue;
  queue.push("a", 1);
  for (int i = 10; i < 14; ++i) queue.push("b", i);
  const auto any = [](int) { return true; };
  CHECK(queue.longest(any) == 4);
  CHECK(queue.take_from_longest(any) == 13);
  // Of those that may go: the line with most of them, and its newest.
  const auto even = [](int item) { return item % 2 == 0; };
  CHECK(queue.longest(even) == 2);
  CHECK(queue.take_from_longest(even) == 12);
  CHECK(queue.size_of("b") == 2);
  CHECK(queue.longest([](int item) { return item > 13; }) == 0);
  CHECK(queue.erase("a", 1));
  CHECK_FALSE(queue.erase("a", 1));
  CHECK_FALSE(queue.erase("b", 1));
  CHECK(queue.clients() == 1);
}

TEST_CASE("the fair queue agrees with a map of lines") {
  FairQueue<int> queue;
  std::map<std::string, std::deque<int>> lines;
  std::deque<int> ahead;
  std::uint32_t state = 5;
  const auto random = [&](std::uint32_t n) {
    return ((state = state * 1664525u + 1013904223u) >> 8) % n;
  };
  std::size_t size = 0;
  for (int step = 0; step < 20'000; ++step) {
    const std::string client(1, static_cast<char>('a' + random(6)));
    switch (random(5)) {
      case 0:
      case 1:
        queue.push(client, step);
        lines[client].push_back(step);
        ++size;
        break;
      case 2: {
        if (queue.empty()) break;
        const int item = queue.pop();
        --size;
        if (!ahead.empty()) {
          CHECK(item == ahead.front());
          ahead.pop_front();
          break;
        }
        bool found = false;
        for (auto& [name, line] : lines) {
          if (line.empty() || line.front() != item) continue;
          line.pop_front();
          found = true;
        }
        CHECK(found);
        break;
      }
      case 3:
        queue.push_ahead(step);
        ahead.push_back(step);
        ++size;
        if (random(4) == 0) {
          const std::size_t at = random(static_cast<std::uint32_t>(ahead.size()));
          CHECK(queue.erase("a", ahead[at]));
          ahead.erase(ahead.begin() + static_cast<std::ptrdiff_t>(at));
          --size;
        }
        break;
      default: {
        auto& line = lines[client];
        if (line.empty()) break;
        const std::size_t at = random(static_cast<std::uint32_t>(line.size()));
        CHECK(queue.erase(client, line[at]));
        line.erase(line.begin() + static_cast<std::ptrdiff_t>(at));
        --size;
      }
    }
    CHECK(queue.size() == size);
    CHECK(queue.waiting_for_turn() == size - ahead.size());
    for (const auto& [name, line] : lines) CHECK(queue.size_of(name) == line.size());
  }
}
