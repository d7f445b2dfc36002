// The distances that a front has given to vertices, as it reads them.
//
// A front of several sources keeps up to four distances of a vertex, each from another source. A
// distance is computed from distances of the same source alone, for circles round different sources
// have no virtual source in common. So vertices near a line where two sources meet need their
// neighbours' distances from both.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "core/field/field.h"

namespace geodesic {

// Where what a front knows of a vertex from one source is kept, by number. The first slot of vertex
// v is v. Further slots come after those of all vertices.
using Slot = std::uint32_t;

// The slots of a front of several sources: a list of them for each vertex.
struct SourceSlots {
  std::vector<std::uint32_t> source;          // of each slot; kNone while it is empty
  std::vector<Slot> next;                     // of the same vertex, or kNone
  std::vector<std::uint32_t> vertex_of_more;  // of the slots after the first ones

  static constexpr std::size_t kBytesOfSlot = 2 * sizeof(std::uint32_t) + sizeof(Slot);

  // None of this many vertices has a source.
  void reset(std::size_t vertices) {
    source.assign(vertices, kNone);
    next.assign(vertices, kNone);
    vertex_of_more.clear();
  }
  [[nodiscard]] std::size_t size() const { return source.size(); }
  [[nodiscard]] std::size_t vertices() const { return source.size() - vertex_of_more.size(); }
  [[nodiscard]] std::uint32_t vertex_of(Slot slot) const {
    return slot < vertices() ? slot : vertex_of_more[slot - vertices()];
  }
  // So many slots may be there before any moves in memory.
  [[nodiscard]] std::size_t capacity() const {
    return std::min({source.capacity(), next.capacity(), vertices() + vertex_of_more.capacity()});
  }
  void reserve(std::size_t slots) {
    source.reserve(slots);
    next.reserve(slots);
    vertex_of_more.reserve(slots - vertices());
  }
  // A new slot of the vertex, of which `last` is the last one so far.
  [[nodiscard]] Slot add(std::uint32_t vertex, Slot last, std::uint32_t number) {
    const auto slot = static_cast<Slot>(source.size());
    source.push_back(number);
    next.push_back(kNone);
    vertex_of_more.push_back(vertex);
    next[last] = slot;
    return slot;
  }
};

class FrontDistances {
 public:
  // `slots`: null where there is one source. Then there is a distance a vertex, else one a slot.
  // All must outlive this object, which is of no use once a vector of them has grown.
  explicit FrontDistances(std::span<const double> distances, const SourceSlots* slots = nullptr)
      : distance_(distances.data()) {
    if (slots == nullptr) return;
    source_ = slots->source.data();
    next_ = slots->next.data();
    vertex_of_more_ = slots->vertex_of_more.data();
    vertices_ = slots->vertices();
  }

  [[nodiscard]] bool has_several_sources() const { return source_ != nullptr; }
  [[nodiscard]] std::uint32_t vertex_of(Slot slot) const {
    return !has_several_sources() || slot < vertices_ ? slot : vertex_of_more_[slot - vertices_];
  }
  // 0 where there is one.
  [[nodiscard]] std::uint32_t source_of(Slot slot) const {
    return has_several_sources() ? source_[slot] : 0;
  }
  // Where the distance of the vertex from this source is kept; kNone: nowhere.
  [[nodiscard]] Slot find_slot(std::uint32_t vertex, std::uint32_t source) const {
    if (!has_several_sources()) return vertex;
    Slot slot = vertex;
    while (slot != kNone && source_[slot] != source) slot = next_[slot];
    return slot;
  }
  [[nodiscard]] double in(Slot slot) const { return distance_[slot]; }
  // From this source, without its offset. kUnreached: none.
  [[nodiscard]] double at(std::uint32_t vertex, std::uint32_t source) const {
    return has_several_sources() ? at<true>(vertex, source) : at<false>(vertex, source);
  }
  // The same for who knows whether there are several. Inlined by force: traces do little else.
  template <bool kSeveralSources>
  [[nodiscard]] __attribute__((always_inline)) double at(std::uint32_t vertex,
                                                         std::uint32_t source) const {
    const double distance = distance_[vertex];
    if constexpr (!kSeveralSources) return distance;
    // No branch asks whether the slot is empty, for nobody could predict that where a front ends.
    // The product is 0 if it is, or if it is of this source. What is empty has no distance.
    const std::uint32_t first = source_[vertex];
    if (std::uint64_t{first ^ source} * std::uint64_t{first ^ kNone} == 0) [[likely]]
      return distance;
    return in_further_slot(vertex, source);
  }

 private:
  [[nodiscard]] __attribute__((noinline)) double in_further_slot(std::uint32_t vertex,
                                                                 std::uint32_t source) const {
    const Slot slot = find_slot(next_[vertex], source);
    return slot == kNone ? kUnreached : distance_[slot];
  }
  const double* distance_;
  const std::uint32_t* source_ = nullptr;
  const Slot* next_ = nullptr;
  const std::uint32_t* vertex_of_more_ = nullptr;
  std::size_t vertices_ = 0;
};

}  // namespace geodesic
