#include "proto/gltf/scene.h"

#include <algorithm>
#include <optional>
#include <string>
#include <utility>

#include "proto/gltf/instancing.h"
#include "proto/wire/number.h"

namespace geodesic::proto {
namespace {

// A node that is its own ancestor, wherever it is in the document; otherwise all
// nodes, children before their parents, in `order`.
std::optional<std::size_t> find_cycle(const GltfDocument& document,
                                      std::vector<std::size_t>& order) {
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
        order.push_back(node);
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

// What drawing a node and its descendants comes to. A node drawn for several parents
// counts each time, so few nodes may come to more than any number holds.
struct Weight {
  double visits = 0;
  double vertices = 0;
};

// Of each mesh, drawn once. Found before the nodes are gone through, as any number of them may
// draw a mesh of any number of primitives.
std::vector<double> vertices_of_meshes(const GltfDocument& document) {
  std::vector<double> vertices;
  vertices.reserve(document.meshes.size());
  for (const GltfMesh& mesh : document.meshes) {
    double sum = 0;
    for (const GltfPrimitive& primitive : mesh.primitives) {
      if (!primitive.position) continue;
      sum += static_cast<double>(document.accessors[*primitive.position].count);
    }
    vertices.push_back(sum);
  }
  return vertices;
}

std::vector<Weight> weigh(const GltfDocument& document, const std::vector<std::size_t>& order) {
  const std::vector<double> vertices = vertices_of_meshes(document);
  std::vector<Weight> weights(document.nodes.size());
  for (const std::size_t i : order) {
    const GltfNode& node = document.nodes[i];
    Weight& weight = weights[i];
    weight.visits = 1;
    if (node.mesh) weight.vertices = vertices[*node.mesh];
    for (const std::size_t child : node.children) {
      weight.visits += weights[child].visits;
      weight.vertices += weights[child].vertices;
    }
  }
  return weights;
}

// Before a list of all that is drawn is made, which would be long.
Result<void> check_weight(const std::vector<Weight>& weights, const std::vector<std::size_t>& roots,
                          std::optional<std::size_t> only, const DecodeLimits& limits) {
  Weight sum;
  for (const std::size_t root : roots) {
    sum.visits += weights[root].visits;
    sum.vertices += weights[root].vertices;
  }
  if (only) sum.vertices = weights[*only].vertices;
  const auto whole = [](double value) { return static_cast<std::uint64_t>(std::min(value, 1e18)); };
  if (whole(sum.visits) > limits.max_nodes) {
    return fail_limit(ErrorCode::too_large, "The scene has too many nodes.", limits.max_nodes,
                      whole(sum.visits));
  }
  if (whole(sum.vertices) > limits.max_vertices) {
    return fail_limit(ErrorCode::too_many_vertices, "The mesh has too many vertices.",
                      limits.max_vertices, whole(sum.vertices));
  }
  return {};
}

// Which of `count` the text means, by index or by name.
template <class NameOf>
std::optional<std::size_t> chosen(const std::string& text, std::size_t count,
                                  const NameOf& name_of) {
  if (const auto index = parse_whole(text)) {
    if (*index >= count) return std::nullopt;
    return static_cast<std::size_t>(*index);
  }
  for (std::size_t i = 0; i < count; ++i) {
    if (name_of(i) == text) return i;
  }
  return std::nullopt;
}

std::vector<std::size_t> roots_of(const GltfDocument& document, std::optional<std::size_t> scene) {
  if (scene) return document.scenes[*scene];
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
                                                 const ImportOptions& options,
                                                 const DecodeLimits& limits,
                                                 std::uint64_t max_absent) {
  std::optional<std::size_t> scene;
  if (options.scene) {
    scene = chosen(*options.scene, document.scenes.size(),
                   [&](std::size_t i) { return document.scene_names[i]; });
    if (!scene) {
      return fail(ErrorCode::value_out_of_range, "The file has no such scene.", "scene");
    }
  }
  std::optional<std::size_t> only;
  if (options.node) {
    only = chosen(*options.node, document.nodes.size(),
                  [&](std::size_t i) { return document.nodes[i].name; });
    if (!only) return fail(ErrorCode::value_out_of_range, "The file has no such node.", "node");
  }
  std::vector<std::size_t> order;
  if (const auto node = find_cycle(document, order)) {
    return fail(ErrorCode::mesh_invalid,
                "node " + std::to_string(*node) + " is among its own descendants.");
  }
  struct Visit {
    std::size_t node;
    GltfTransform parent;
    bool is_wanted;
  };
  std::vector<Visit> pending;
  std::uint64_t visits = 0;
  // Last first, so that the first is on top. Counted before memory is taken.
  const auto push = [&](const std::vector<std::size_t>& nodes, const GltfTransform& parent,
                        bool is_wanted) {
    visits += nodes.size();
    if (visits > limits.max_nodes) return false;
    for (std::size_t i = nodes.size(); i-- > 0;) pending.push_back({nodes[i], parent, is_wanted});
    return true;
  };
  const auto roots = roots_of(document, scene);
  if (const auto light = check_weight(weigh(document, order), roots, only, limits); !light) {
    return fail(light.error());
  }
  bool within = push(roots, GltfTransform{}, !only);
  bool is_met = !only;
  std::vector<GltfInstance> instances;
  while (within && !pending.empty()) {
    const Visit visit = pending.back();
    pending.pop_back();
    const GltfNode& node = document.nodes[visit.node];
    const GltfTransform to_world = visit.parent.after(node.to_parent);
    const bool is_wanted = visit.is_wanted || visit.node == only;
    is_met = is_met || is_wanted;
    if (!is_wanted || !node.mesh) {
      // nothing to draw here
    } else if (node.instancing) {
      const auto placed =
          read_instancing(document, buffers, visit.node, limits.max_nodes - visits, max_absent);
      if (!placed) return fail(placed.error());
      visits += placed->size();
      for (const GltfTransform& to_node : *placed) {
        instances.push_back({visit.node, *node.mesh, to_world.after(to_node)});
      }
    } else {
      instances.push_back({visit.node, *node.mesh, to_world});
    }
    within = push(node.children, to_world, is_wanted);
  }
  if (!within) {
    return fail_limit(ErrorCode::too_large, "The scene has too many nodes.", limits.max_nodes,
                      visits);
  }
  if (!is_met) {
    return fail(ErrorCode::value_out_of_range, "The scene does not contain this node.", "node");
  }
  return instances;
}

}  // namespace geodesic::proto
