#include "proto/gltf_scene.h"

#include <optional>
#include <string>
#include <utility>

#include "proto/gltf_instancing.h"

namespace geodesic::proto {
namespace {

// A node that is its own ancestor, wherever it is in the document.
std::optional<std::size_t> find_cycle(const GltfDocument& document) {
  enum class Mark : std::uint8_t { unseen, on_path, done };
  std::vector<Mark> marks(document.nodes.size(), Mark::unseen);
  std::vector<std::pair<std::size_t, std::size_t>> path;  // node, its next child
  for (std::size_t start = 0; start < document.nodes.size(); ++start) {
    if (marks[start] != Mark::unseen) continue;
    marks[start] = Mark::on_path;
    path.emplace_back(start, 0);
    while (!path.empty()) {
      auto& [node, next] = path.back();
      const auto& children = document.nodes[node].children;
      if (next == children.size()) {
        marks[node] = Mark::done;
        path.pop_back();
        continue;
      }
      const std::size_t child = children[next++];
      if (marks[child] == Mark::on_path) return child;
      if (marks[child] == Mark::done) continue;
      marks[child] = Mark::on_path;
      path.emplace_back(child, 0);
    }
  }
  return std::nullopt;
}

std::vector<std::size_t> roots_of(const GltfDocument& document) {
  if (!document.scenes.empty()) return document.scenes[document.scene.value_or(0)];
  std::vector<bool> is_child(document.nodes.size(), false);
  for (const GltfNode& node : document.nodes) {
    for (const std::size_t child : node.children) is_child[child] = true;
  }
  std::vector<std::size_t> roots;
  for (std::size_t i = 0; i < is_child.size(); ++i) {
    if (!is_child[i]) roots.push_back(i);
  }
  return roots;
}

}  // namespace

Result<std::vector<GltfInstance>> find_instances(const GltfDocument& document, GltfBuffers& buffers,
                                                 std::uint64_t max_nodes,
                                                 std::uint64_t max_absent) {
  if (const auto node = find_cycle(document)) {
    return fail(ErrorCode::mesh_invalid,
                "node " + std::to_string(*node) + " is among its own descendants.");
  }
  struct Visit {
    std::size_t node;
    GltfTransform parent;
  };
  std::vector<Visit> pending;
  std::uint64_t visits = 0;
  // Last first, so that the first is on top. Counted before memory is taken.
  const auto push = [&](const std::vector<std::size_t>& nodes, const GltfTransform& parent) {
    visits += nodes.size();
    if (visits > max_nodes) return false;
    for (std::size_t i = nodes.size(); i-- > 0;) pending.push_back({nodes[i], parent});
    return true;
  };
  bool within = push(roots_of(document), GltfTransform{});
  std::vector<GltfInstance> instances;
  while (within && !pending.empty()) {
    const Visit visit = pending.back();
    pending.pop_back();
    const GltfNode& node = document.nodes[visit.node];
    const GltfTransform to_world = visit.parent.after(node.to_parent);
    if (node.mesh && node.instancing) {
      const auto placed =
          read_instancing(document, buffers, visit.node, max_nodes - visits, max_absent);
      if (!placed) return fail(placed.error());
      visits += placed->size();
      for (const GltfTransform& to_node : *placed) {
        instances.push_back({visit.node, *node.mesh, to_world.after(to_node)});
      }
    } else if (node.mesh) {
      instances.push_back({visit.node, *node.mesh, to_world});
    }
    within = push(node.children, to_world);
  }
  if (!within) {
    return fail_limit(ErrorCode::too_large, "The scene has too many nodes.", max_nodes, visits);
  }
  return instances;
}

}  // namespace geodesic::proto
