// A queue in which clients take turns: each has a line of its own, first in first
// out, and `pop` serves the lines round robin. So one client's thousand items
// delay another's first by one turn, and not by a thousand. Items that are pushed ahead
// wait for no turn. Not thread-safe.
#pragma once

#include <algorithm>
#include <cstddef>
#include <deque>
#include <iterator>
#include <list>
#include <string>
#include <unordered_map>
#include <utility>

namespace geodesic::server {

template <class T>
class FairQueue {
 public:
  [[nodiscard]] bool empty() const { return size_ == 0; }
  [[nodiscard]] std::size_t size() const { return size_; }
  [[nodiscard]] std::size_t waiting_for_turn() const { return size_ - ahead_.size(); }
  [[nodiscard]] std::size_t clients() const { return lines_.size(); }
  // Items of one client that wait for a turn.
  [[nodiscard]] std::size_t size_of(const std::string& client) const {
    const auto found = of_client_.find(client);
    return found == of_client_.end() ? 0 : found->second->items.size();
  }
  // How many `pop`s come before that of an item pushed now.
  [[nodiscard]] std::size_t turns_before(const std::string& client) const {
    const std::size_t mine = size_of(client);
    std::size_t turns = ahead_.size();
    for (const Line& line : lines_) turns += std::min(line.items.size(), mine + 1);
    return turns;
  }

  void push(const std::string& client, T item) {
    auto found = of_client_.find(client);
    if (found == of_client_.end()) {
      lines_.push_back(Line{client, {}});
      found = of_client_.emplace(client, std::prev(lines_.end())).first;
    }
    found->second->items.push_back(std::move(item));
    ++size_;
  }

  // Puts an item before all that wait for a turn, and behind those that went ahead earlier.
  void push_ahead(T item) {
    ahead_.push_back(std::move(item));
    ++size_;
  }

  // The oldest item that was pushed ahead, or else that of the client whose turn it is. Requires
  // that there is one.
  [[nodiscard]] T pop() {
    if (!ahead_.empty()) {
      T item = std::move(ahead_.front());
      ahead_.pop_front();
      --size_;
      return item;
    }
    const auto line = lines_.begin();
    T item = std::move(line->items.front());
    line->items.pop_front();
    --size_;
    lines_.splice(lines_.end(), lines_, line);
    drop_if_empty(line);
    return item;
  }

  // The most items that may go in one line; 0 if there are none.
  template <class MayGo>
  [[nodiscard]] std::size_t longest(const MayGo& may_go) const {
    std::size_t most = 0;
    for (const Line& line : lines_) most = std::max(most, count(line, may_go));
    return most;
  }
  // Takes the newest item that may go out of the line with most of them. Requires that there
  // is one.
  template <class MayGo>
  [[nodiscard]] T take_from_longest(const MayGo& may_go) {
    const auto line = std::max_element(
        lines_.begin(), lines_.end(),
        [&](const Line& a, const Line& b) { return count(a, may_go) < count(b, may_go); });
    const auto newest = std::find_if(line->items.rbegin(), line->items.rend(), may_go);
    T item = std::move(*newest);
    line->items.erase(std::next(newest).base());
    --size_;
    drop_if_empty(line);
    return item;
  }

  // Takes one item out, wherever it is; false if it is not there.
  bool erase(const std::string& client, const T& item) {
    if (const auto at = std::find(ahead_.begin(), ahead_.end(), item); at != ahead_.end()) {
      ahead_.erase(at);
      --size_;
      return true;
    }
    const auto found = of_client_.find(client);
    if (found == of_client_.end()) return false;
    auto& items = found->second->items;
    const auto position = std::find(items.begin(), items.end(), item);
    if (position == items.end()) return false;
    items.erase(position);
    --size_;
    drop_if_empty(found->second);
    return true;
  }

 private:
  struct Line {
    std::string client;
    std::deque<T> items;
  };
  using Lines = std::list<Line>;

  template <class MayGo>
  static std::size_t count(const Line& line, const MayGo& may_go) {
    return static_cast<std::size_t>(std::count_if(line.items.begin(), line.items.end(), may_go));
  }

  void drop_if_empty(typename Lines::iterator line) {
    if (!line->items.empty()) return;
    of_client_.erase(line->client);
    lines_.erase(line);
  }

  std::deque<T> ahead_;
  Lines lines_;  // none is empty; the first is the one whose turn it is
  std::unordered_map<std::string, typename Lines::iterator> of_client_;
  std::size_t size_ = 0;
};

}  // namespace geodesic::server
