// What cpp-httplib does by itself, to compare with: each file named on the command
// line is answered from memory at /0, /1, ….
//
//     bare_server FILE...        prints its port
#include <httplib.h>

#include <cstdio>
#include <fstream>
#include <iterator>
#include <memory>
#include <string>

int main(int argc, char** argv) {
  httplib::Server server;
  server.set_tcp_nodelay(true);
  server.set_keep_alive_max_count(1'000'000'000);
  server.new_task_queue = [] { return new httplib::ThreadPool(64); };
  for (int i = 1; i < argc; ++i) {
    std::ifstream file(argv[i], std::ios::binary);
    const auto bytes = std::make_shared<const std::string>(std::istreambuf_iterator<char>(file),
                                                           std::istreambuf_iterator<char>());
    server.Get("/" + std::to_string(i - 1),
               [bytes](const httplib::Request&, httplib::Response& response) {
                 response.set_content(*bytes, "application/octet-stream");
               });
  }
  const int port = server.bind_to_any_port("127.0.0.1");
  std::printf("%d\n", port);
  std::fflush(stdout);
  return server.listen_after_bind() ? 0 : 1;
}
