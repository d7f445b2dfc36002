// The queue of the paper (section 3.1): a pairing heap of vertices, with the
// interface of core/field/vertex_heap.h, so that the same wavefront runs on both.
// Fredman, Sedgewick, Sleator and Tarjan 1986, two-pass variant.
//
// Nodes lie in an array indexed by vertex: nothing is allocated by a push.
#pragma once

#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

#include "core/field/vertex_heap.h"

namespace geodesic::bench {

class PairingHeap {
 public:
  using Entry = VertexHeap::Entry;

  // Forgets everything; all of `vertex_count` vertices are far. Keeps memory.
  void reset(std::size_t vertex_count) {
    nodes_.assign(vertex_count, Node{});
    root_ = kNil;
  }

  [[nodiscard]] bool empty() const { return root_ == kNil; }
  [[nodiscard]] bool accepted(std::uint32_t vertex) const {
    return nodes_[vertex].previous == kAccepted;
  }

  // Inserts a far vertex, or lowers the key of a considered one. The vertex must
  // not be accepted, and `key` not above its present key.
  void push_or_lower(std::uint32_t vertex, double key) {
    Node& node = nodes_[vertex];
    const bool is_new = node.previous == kFar;
    node.key = key;
    if (is_new) {
      node.previous = kNil;
    } else if (vertex == root_) {
      return;
    } else {
      cut(vertex);
    }
    root_ = root_ == kNil ? vertex : merge(root_, vertex);
  }

  // Removes the vertex of the least key and marks it accepted. Not when empty.
  Entry pop() {
    const std::uint32_t top = root_;
    root_ = merge_pairs(nodes_[top].child);
    nodes_[top].previous = kAccepted;
    return {nodes_[top].key, top};
  }

 private:
  static constexpr std::uint32_t kNil = 0xffffffffU;
  static constexpr std::uint32_t kFar = 0xfffffffeU;
  static constexpr std::uint32_t kAccepted = 0xfffffffdU;

  struct Node {
    double key = 0;
    std::uint32_t child = kNil;     // the first one
    std::uint32_t sibling = kNil;   // the next one
    std::uint32_t previous = kFar;  // sibling, or the parent of a first child; kNil at the root
  };

  // Takes a vertex that is not the root, with its children, out of its siblings.
  void cut(std::uint32_t vertex) {
    Node& node = nodes_[vertex];
    Node& before = nodes_[node.previous];
    (before.child == vertex ? before.child : before.sibling) = node.sibling;
    if (node.sibling != kNil) nodes_[node.sibling].previous = node.previous;
    node.sibling = kNil;
    node.previous = kNil;
  }

  // Two roots without siblings; returns the one that stays.
  std::uint32_t merge(std::uint32_t a, std::uint32_t b) {
    if (nodes_[b].key < nodes_[a].key) std::swap(a, b);
    Node& above = nodes_[a];
    Node& below = nodes_[b];
    below.sibling = above.child;
    if (above.child != kNil) nodes_[above.child].previous = b;
    below.previous = a;
    above.child = b;
    return a;
  }

  // The children of a removed root: merged in pairs from the left, then the pairs
  // from the right. Returns the new root.
  std::uint32_t merge_pairs(std::uint32_t first) {
    std::uint32_t pairs = kNil;  // a stack, linked by sibling
    while (first != kNil) {
      const std::uint32_t a = first;
      const std::uint32_t b = nodes_[a].sibling;
      first = b == kNil ? kNil : nodes_[b].sibling;
      nodes_[a].sibling = kNil;
      std::uint32_t pair = a;
      if (b != kNil) {
        nodes_[b].sibling = kNil;
        pair = merge(a, b);
      }
      nodes_[pair].sibling = pairs;
      pairs = pair;
    }
    std::uint32_t root = kNil;
    while (pairs != kNil) {
      const std::uint32_t next = nodes_[pairs].sibling;
      nodes_[pairs].sibling = kNil;
      root = root == kNil ? pairs : merge(root, pairs);
      pairs = next;
    }
    if (root != kNil) nodes_[root].previous = kNil;
    return root;
  }

  std::vector<Node> nodes_;
  std::uint32_t root_ = kNil;
};

}  // namespace geodesic::bench
