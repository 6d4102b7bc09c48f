#include <poll.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <assimp/config.h>
#include <assimp/scene.h>
#include <array>
#include <assimp/Importer.hpp>
#include <cerrno>
#include <csignal>
#include <cstring>
#include <fstream>
#include <glm/mat4x4.hpp>

#include "foreview/scene/errors.h"
#include "foreview/scene/mesh_reading.h"

// assimp is not hard enough for damaged files: overflows, endless recursion and huge allocations are known in it. So it
// runs in a child process with limits, and the mesh comes back through a pipe.

namespace foreview {
namespace {

constexpr rlim_t kMaxChildSeconds = 60;
constexpr int kMaxWaitMilliseconds = 120'000;
constexpr std::size_t kMaxNodes = 200'000;

glm::dmat4 to_glm(const aiMatrix4x4& m) {
  // assimp counts rows first, glm columns first.
  return {{m.a1, m.b1, m.c1, m.d1}, {m.a2, m.b2, m.c2, m.d2}, {m.a3, m.b3, m.c3, m.d3}, {m.a4, m.b4, m.c4, m.d4}};
}

/// Everything assimp found, nodes in depth-first order. Throws InputError.
class SceneCollector {
 public:
  SceneCollector(const aiScene& scene, const std::string& where)
      : scene_(scene), where_(where), parts_(mesh_.part_names) {}

  RawMesh run() {
    visit(*scene_.mRootNode, glm::dmat4(1));
    if (mesh_.faces.empty()) throw InputError(where_, "has no faces; expected a mesh");
    return std::move(mesh_);
  }

 private:
  void visit(const aiNode& node, const glm::dmat4& file_from_parent) {
    if (++nodes_ > kMaxNodes) throw InputError(where_, "has more than 200000 nodes; simplify the scene");
    const glm::dmat4 file_from_node = file_from_parent * to_glm(node.mTransformation);
    for (unsigned i = 0; i < node.mNumMeshes; ++i) {
      if (node.mMeshes[i] >= scene_.mNumMeshes) throw InputError(where_, "a node refers to a mesh that is not there");
      const aiMesh* mesh = scene_.mMeshes[node.mMeshes[i]];
      const char* name = node.mName.length > 0 ? node.mName.C_Str() : mesh->mName.C_Str();
      add(*mesh, file_from_node, parts_.index(*name != '\0' ? name : "model", where_));
    }
    for (unsigned i = 0; i < node.mNumChildren; ++i) visit(*node.mChildren[i], file_from_node);
  }

  void add(const aiMesh& mesh, const glm::dmat4& file_from_node, std::uint32_t part) {
    check_mesh_count(mesh_.vertices.size() + mesh.mNumVertices, kMaxMeshCorners, "vertices", where_);
    check_mesh_count(mesh_.faces.size() + mesh.mNumFaces, kMaxMeshFaces, "faces", where_);
    const auto first = static_cast<std::uint32_t>(mesh_.vertices.size());
    for (unsigned i = 0; i < mesh.mNumVertices; ++i) {
      const aiVector3D& v = mesh.mVertices[i];
      mesh_.vertices.emplace_back(file_from_node * glm::dvec4(v.x, v.y, v.z, 1));
    }
    // A mirroring transform turns fronts into backs unless the corners run the other way (glTF 2.0, 3.7.4).
    const bool mirrored = glm::determinant(glm::dmat3(file_from_node)) < 0;
    for (unsigned f = 0; f < mesh.mNumFaces; ++f) {
      const aiFace& face = mesh.mFaces[f];
      corners_ += face.mNumIndices;
      check_mesh_count(corners_, kMaxMeshCorners, "face corners", where_);
      std::vector<std::uint32_t>& corners = mesh_.faces.emplace_back();
      for (unsigned i = 0; i < face.mNumIndices; ++i) {
        const unsigned index = face.mIndices[mirrored ? face.mNumIndices - 1 - i : i];
        corners.push_back(index < mesh.mNumVertices ? first + index : ~0U);
      }
      mesh_.face_part.push_back(part);
    }
  }

  const aiScene& scene_;
  const std::string& where_;
  RawMesh mesh_;
  PartNames parts_;
  std::size_t nodes_ = 0, corners_ = 0;
};

RawMesh import_here(const std::string& file) {
  Assimp::Importer importer;
  // The file's own axes: what "up" is, the recording's poses say.
  importer.SetPropertyBool(AI_CONFIG_IMPORT_COLLADA_IGNORE_UP_DIRECTION, true);
  // No post-processing: polygons stay as they are, vertices are welded and faces cleaned by build_polygon_model().
  const aiScene* scene = importer.ReadFile(file, 0);
  if (scene == nullptr) {
    std::string why = importer.GetErrorString();
    for (char& c : why)
      if (static_cast<unsigned char>(c) < ' ') c = ' ';
    throw InputError(file, "cannot be read as a mesh: " + why);
  }
  if ((scene->mFlags & AI_SCENE_FLAGS_INCOMPLETE) != 0 || scene->mRootNode == nullptr || scene->mNumMeshes == 0)
    throw InputError(file, "holds no mesh that could be read; expected a mesh");
  return SceneCollector(*scene, file).run();
}

// The pipe carries one byte (1: a mesh follows, 0: an error message), then the mesh as counts and arrays.

bool write_all(int pipe, const void* data, std::size_t size) {
  const char* at = static_cast<const char*>(data);
  while (size > 0) {
    const ssize_t written = write(pipe, at, size);
    if (written < 0 && errno == EINTR) continue;
    if (written <= 0) return false;
    at += written;
    size -= static_cast<std::size_t>(written);
  }
  return true;
}

std::string serialise(const RawMesh& mesh) {
  std::string bytes(1, '\1');
  const auto append = [&](const void* data, std::size_t size) { bytes.append(static_cast<const char*>(data), size); };
  const auto append_count = [&](std::size_t count) {
    const std::uint64_t word = count;
    append(&word, sizeof(word));
  };
  append_count(mesh.vertices.size());
  append(mesh.vertices.data(), mesh.vertices.size() * sizeof(glm::dvec3));
  append_count(mesh.faces.size());
  for (const auto& face : mesh.faces) {
    append_count(face.size());
    append(face.data(), face.size() * sizeof(std::uint32_t));
  }
  append(mesh.face_part.data(), mesh.face_part.size() * sizeof(std::uint32_t));
  append_count(mesh.part_names.size());
  for (const std::string& name : mesh.part_names) {
    append_count(name.size());
    append(name.data(), name.size());
  }
  return bytes;
}

/// The child may have been out of its mind when it wrote this: every count is checked against what is there.
class Deserialiser {
 public:
  explicit Deserialiser(std::string_view bytes) : rest_(bytes) {}
  bool read(RawMesh& mesh) {
    std::uint64_t count = 0;
    if (!take_count(count, sizeof(glm::dvec3))) return false;
    mesh.vertices.resize(count);
    if (!take(mesh.vertices.data(), count * sizeof(glm::dvec3)) || !take_count(count, sizeof(std::uint64_t)))
      return false;
    mesh.faces.resize(count);
    for (auto& face : mesh.faces) {
      std::uint64_t corners = 0;
      if (!take_count(corners, sizeof(std::uint32_t))) return false;
      face.resize(corners);
      if (!take(face.data(), corners * sizeof(std::uint32_t))) return false;
    }
    if (count * sizeof(std::uint32_t) > rest_.size()) return false;
    mesh.face_part.resize(count);
    if (!take(mesh.face_part.data(), count * sizeof(std::uint32_t)) || !take_count(count, sizeof(std::uint64_t)))
      return false;
    mesh.part_names.resize(count);
    for (std::string& name : mesh.part_names) {
      std::uint64_t length = 0;
      if (!take_count(length, 1)) return false;
      name.resize(length);
      if (!take(name.data(), length)) return false;
    }
    return rest_.empty();
  }

 private:
  bool take(void* to, std::size_t size) {
    if (size > rest_.size()) return false;
    if (size > 0) std::memcpy(to, rest_.data(), size);
    rest_.remove_prefix(size);
    return true;
  }
  bool take_count(std::uint64_t& count, std::size_t item_size) {
    return take(&count, sizeof(count)) && count <= rest_.size() / item_size;
  }
  std::string_view rest_;
};

void limit_child() {
  const auto set = [](auto resource, rlim_t value) {
    const rlimit limit{value, value};
    setrlimit(resource, &limit);
  };
  set(RLIMIT_CORE, 0);
  set(RLIMIT_CPU, kMaxChildSeconds);
#if defined(__has_feature)
#if __has_feature(address_sanitizer) || __has_feature(thread_sanitizer)
#define FOREVIEW_SANITIZED
#endif
#elif defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
#define FOREVIEW_SANITIZED
#endif
#ifndef FOREVIEW_SANITIZED  // sanitizers reserve terabytes of addresses
  constexpr std::size_t kMaxChildMemory = std::size_t{4} << 30;
  std::size_t pages = 0;
  std::ifstream("/proc/self/statm") >> pages;
  set(RLIMIT_AS, pages * static_cast<std::size_t>(sysconf(_SC_PAGESIZE)) + kMaxChildMemory);
#endif
  // Nobody's handlers: a crash here is expected and must stay quiet.
  for (const int number : {SIGSEGV, SIGBUS, SIGABRT, SIGFPE, SIGILL, SIGXCPU, SIGTERM, SIGINT})
    std::signal(number, SIG_DFL);
}

[[noreturn]] void run_child(int pipe, const std::string& file) {
  limit_child();
  // What assimp or the C++ runtime says when it dies would only confuse: the parent has the one line.
  if (std::freopen("/dev/null", "w", stderr) == nullptr) _exit(1);
  std::string answer;
  try {
    answer = serialise(import_here(file));
  } catch (const InputError& error) {
    answer = std::string(1, '\0') + error.what();
  } catch (const std::exception& error) {
    answer = std::string(1, '\0') + file + ": cannot be read as a mesh: " + error.what();
  }
  _exit(write_all(pipe, answer.data(), answer.size()) ? 0 : 1);
}

class FileDescriptor {
 public:
  explicit FileDescriptor(int number) : number_(number) {}
  ~FileDescriptor() { reset(); }
  FileDescriptor(const FileDescriptor&) = delete;
  FileDescriptor& operator=(const FileDescriptor&) = delete;
  [[nodiscard]] int get() const { return number_; }
  void reset() {
    if (number_ >= 0) close(number_);
    number_ = -1;
  }

 private:
  int number_;
};

std::string read_answer(int pipe) {
  std::string answer;
  std::array<char, 65536> buffer{};
  while (true) {
    pollfd waiting{pipe, POLLIN, 0};
    const int ready = poll(&waiting, 1, kMaxWaitMilliseconds);
    if (ready < 0 && errno == EINTR) continue;
    if (ready <= 0) return answer;
    const ssize_t count = read(pipe, buffer.data(), buffer.size());
    if (count < 0 && errno == EINTR) continue;
    if (count <= 0) return answer;
    answer.append(buffer.data(), static_cast<std::size_t>(count));
  }
}

}  // namespace

RawMesh read_with_assimp(const std::filesystem::path& file) {
  const std::string name = file.string();
  {
    const Assimp::Importer importer;
    if (!importer.IsExtensionSupported(file.extension().string()))
      throw InputError(name, "is of no known mesh format; expected .obj, .ply, .stl, .off, .gltf, .glb or .dae");
  }
  std::array<int, 2> ends{};
  if (pipe(ends.data()) != 0) throw InputError(name, "cannot be read: no pipe: " + std::string(std::strerror(errno)));
  FileDescriptor from_child(ends[0]);
  FileDescriptor to_parent(ends[1]);
  const pid_t child = fork();
  if (child < 0) throw InputError(name, "cannot be read: no process: " + std::string(std::strerror(errno)));
  if (child == 0) run_child(to_parent.get(), name);
  to_parent.reset();
  const std::string answer = read_answer(from_child.get());
  // Finished, dead or hanging: its answer is all that counts.
  kill(child, SIGKILL);
  int status = 0;
  while (waitpid(child, &status, 0) < 0 && errno == EINTR) {
  }
  if (answer.empty())
    throw InputError(name,
                     "is damaged: reading it broke down (crash, endless loop or too much memory); export it again");
  if (answer[0] == '\0') {
    std::string why = answer.substr(1);
    if (why.rfind(name + ": ", 0) == 0) why = why.substr(name.size() + 2);
    throw InputError(name, why);
  }
  RawMesh mesh;
  if (!Deserialiser(std::string_view(answer).substr(1)).read(mesh))
    throw InputError(name, "is damaged: reading it broke down half-way; export it again");
  return mesh;
}

}  // namespace foreview
