#include <OpenMesh/Core/Mesh/PolyMesh_ArrayKernelT.hh>
#include <algorithm>
#include <glm/geometric.hpp>
#include <numeric>
#include <tuple>

#include "foreview/scene/polygon_face.h"

namespace foreview {
namespace {

using Mesh = OpenMesh::PolyMesh_ArrayKernelT<>;

struct HalfEdge {
  std::uint32_t low, high;  // the edge's vertices
  std::uint32_t face;
  std::uint32_t corner, next;  // numbers of the corners where it begins and ends, over all faces
  bool forward;                // from low to high
};

std::vector<HalfEdge> sorted_half_edges(const std::vector<Face>& faces) {
  std::vector<HalfEdge> edges;
  std::uint32_t first = 0;
  for (std::uint32_t f = 0; f < faces.size(); ++f) {
    const auto& corners = faces[f].corners;
    const auto count = static_cast<std::uint32_t>(corners.size());
    for (std::uint32_t i = 0; i < count; ++i) {
      const std::uint32_t u = corners[i];
      const std::uint32_t v = corners[(i + 1) % count];
      edges.push_back({std::min(u, v), std::max(u, v), f, first + i, first + (i + 1) % count, u < v});
    }
    first += count;
  }
  std::sort(edges.begin(), edges.end(), [](const HalfEdge& a, const HalfEdge& b) {
    return std::tie(a.low, a.high, a.corner) < std::tie(b.low, b.high, b.corner);
  });
  return edges;
}

/// Union-find over corners: those in one set stay one vertex.
class CornerFans {
 public:
  explicit CornerFans(std::size_t count) : parent_(count) { std::iota(parent_.begin(), parent_.end(), 0U); }
  std::uint32_t find(std::uint32_t i) {
    while (parent_[i] != i) i = parent_[i] = parent_[parent_[i]];
    return i;
  }
  void join(std::uint32_t a, std::uint32_t b) {
    a = find(a);
    b = find(b);
    parent_[std::max(a, b)] = std::min(a, b);
  }

 private:
  std::vector<std::uint32_t> parent_;
};

/// OpenMesh says on a stream of its own what it refuses; here every refusal has an answer.
class QuietOpenMesh {
 public:
  QuietOpenMesh() { ::omerr().disable(); }
  ~QuietOpenMesh() { ::omerr().enable(); }
  QuietOpenMesh(const QuietOpenMesh&) = delete;
  QuietOpenMesh& operator=(const QuietOpenMesh&) = delete;
};

bool fits(const Mesh& mesh, const std::vector<Mesh::VertexHandle>& corners) {
  for (std::size_t i = 0; i < corners.size(); ++i) {
    if (!mesh.is_boundary(corners[i])) return false;
    const auto edge = mesh.find_halfedge(corners[i], corners[(i + 1) % corners.size()]);
    if (edge.is_valid() && !mesh.is_boundary(edge)) return false;
  }
  return true;
}

}  // namespace

Topology make_manifold(std::vector<glm::dvec3>& vertices, std::vector<Face>& faces) {
  Topology topology;
  const std::vector<HalfEdge> edges = sorted_half_edges(faces);
  std::vector<bool> on_boundary(edges.size(), false);  // by corner
  std::vector<double> lengths;
  CornerFans fans(edges.size());
  for (std::size_t i = 0; i < edges.size();) {
    std::size_t end = i + 1;
    while (end < edges.size() && edges[end].low == edges[i].low && edges[end].high == edges[i].high) ++end;
    lengths.push_back(glm::distance(vertices[edges[i].low], vertices[edges[i].high]));
    const std::size_t count = end - i;
    const HalfEdge& a = edges[i];
    if (count == 1) {
      ++topology.boundary_edges;
      on_boundary[a.corner] = true;
    } else if (count > 2) {
      ++topology.not_manifold_edges;
    } else if (a.forward == edges[i + 1].forward) {
      ++topology.opposed_edges;
    } else {
      fans.join(a.corner, edges[i + 1].next);
      fans.join(a.next, edges[i + 1].corner);
    }
    // Round the edge, not each with each: a fan of thousands on one edge would have millions of pairs.
    for (std::size_t k = i; k < end; ++k) {
      const std::uint32_t other = edges[k + 1 < end ? k + 1 : i].face;
      if (other != edges[k].face)
        topology.adjacent.emplace_back(std::min(edges[k].face, other), std::max(edges[k].face, other));
    }
    i = end;
  }
  if (!lengths.empty()) {
    const auto middle = lengths.begin() + static_cast<std::ptrdiff_t>(lengths.size() / 2);
    std::nth_element(lengths.begin(), middle, lengths.end());
    topology.median_edge = *middle;
  }

  // Each fan of corners becomes a vertex; the first keeps the old one.
  constexpr std::uint32_t kNone = ~0U;
  std::vector<std::uint32_t> vertex_of_fan(edges.size(), kNone);
  std::vector<bool> taken(vertices.size(), false);
  std::uint32_t corner_number = 0;
  for (Face& face : faces) {
    for (std::uint32_t& corner : face.corners) {
      std::uint32_t& vertex = vertex_of_fan[fans.find(corner_number++)];
      if (vertex == kNone && !taken[corner]) {
        taken[corner] = true;
        vertex = corner;
      } else if (vertex == kNone) {
        vertex = static_cast<std::uint32_t>(vertices.size());
        vertices.push_back(vertices[corner]);
        ++topology.vertices_split;
      }
      corner = vertex;
    }
  }

  // OpenMesh is the judge of what is a manifold: a face that it would refuse gets vertices of its own.
  const QuietOpenMesh quiet;
  Mesh mesh;
  mesh.reserve(vertices.size(), edges.size(), faces.size());
  for (std::size_t i = 0; i < vertices.size(); ++i) mesh.add_vertex(Mesh::Point(0, 0, 0));
  std::vector<Mesh::VertexHandle> handles;
  std::vector<bool> rim;  // by OpenMesh edge: a true rim, not a cut
  corner_number = 0;
  for (Face& face : faces) {
    handles.clear();
    for (const std::uint32_t corner : face.corners) handles.emplace_back(static_cast<int>(corner));
    Mesh::FaceHandle added;
    if (fits(mesh, handles)) added = mesh.add_face(handles);
    if (!added.is_valid()) {
      for (std::size_t i = 0; i < handles.size(); ++i) {
        handles[i] = mesh.add_vertex(Mesh::Point(0, 0, 0));
        vertices.push_back(vertices[face.corners[i]]);
        face.corners[i] = static_cast<std::uint32_t>(handles[i].idx());
        ++topology.vertices_split;
      }
      mesh.add_face(handles);
    }
    rim.resize(mesh.n_edges(), false);
    for (std::size_t i = 0; i < handles.size(); ++i, ++corner_number) {
      if (!on_boundary[corner_number]) continue;
      const auto edge = mesh.find_halfedge(handles[i], handles[(i + 1) % handles.size()]);
      if (edge.is_valid()) rim[static_cast<std::size_t>(mesh.edge_handle(edge).idx())] = true;
    }
  }
  std::vector<bool> visited(mesh.n_halfedges(), false);
  for (const auto start : mesh.halfedges()) {
    if (!mesh.is_boundary(start) || visited[static_cast<std::size_t>(start.idx())]) continue;
    bool true_rim = false;
    for (Mesh::HalfedgeHandle h = start; !visited[static_cast<std::size_t>(h.idx())];
         h = mesh.next_halfedge_handle(h)) {
      visited[static_cast<std::size_t>(h.idx())] = true;
      true_rim = true_rim || rim[static_cast<std::size_t>(mesh.edge_handle(h).idx())];
    }
    topology.boundary_loops += true_rim ? 1 : 0;
  }
  std::sort(topology.adjacent.begin(), topology.adjacent.end());
  topology.adjacent.erase(std::unique(topology.adjacent.begin(), topology.adjacent.end()), topology.adjacent.end());
  return topology;
}

}  // namespace foreview
