#include "server/http/content_disposition.h"

#include <doctest/doctest.h>

#include <optional>
#include <string>
#include <string_view>

using namespace geodesic::server;

// The cases of RFC 6266, section 5, and what browsers and curl send.
TEST_CASE("TheFileNameOfAContentDispositionIsFound") {
  struct Case {
    std::string_view header;
    std::optional<std::string> name;
  };
  const Case cases[] = {
      {"attachment; filename=bunny.glb", "bunny.glb"},
      {"Attachment; FileName=\"a b.glb\"", "a b.glb"},
      {"attachment; filename=\"a;b.glb\"", "a;b.glb"},
      {R"(attachment; filename="say \"hi\".glb")", "say \"hi\".glb"},
      {"attachment; filename= \"x.glb\" ; size=7", "x.glb"},
      {"attachment; filename*=UTF-8''%e2%82%ac%20rates", "€ rates"},
      {"attachment; filename=\"EURO.glb\"; filename*=utf-8''%e2%82%ac.glb", "€.glb"},
      {"attachment; filename*=utf-8'en'a.glb; filename=b.glb", "a.glb"},
      {"attachment; filename=\"/home/me/a.glb\"", "a.glb"},
      {"attachment; filename=\"C:\\\\meshes\\\\a.glb\"", "a.glb"},
      {"attachment; filename*=iso-8859-1''%a3; filename=pound.glb", "pound.glb"},
      {"attachment; filename*=utf-8''%zz; filename=b.glb", "b.glb"},
      {"attachment; filename*=utf-8''%ff; filename=b.glb", "b.glb"},
      {R"(attachment; filename="C:\x\y.glb")", "y.glb"},
      {R"(attachment; filename="a\)", std::nullopt},
      {"attachment; filename=\"a", std::nullopt},
      {"attachment; filename=\"a\"b", std::nullopt},
      {"attachment; filename=..", ""},
      {"attachment; filename=\"a/.\"", ""},
      {"attachment; filename*=utf-8''%e", std::nullopt},
      {"attachment; filename*=utf-8''%00", std::nullopt},
      {"attachment; filename=\"\"", ""},
      {"attachment; filename", ""},
      {"attachment; filename=\"a/\"", ""},
      {"attachment", std::nullopt},
      {"", std::nullopt},
      {";;=;\"", std::nullopt},
      {"filename=a.glb", std::nullopt},  // no type before it
  };
  for (const Case& one : cases) {
    CAPTURE(one.header);
    CHECK(file_name_in_disposition(one.header) == one.name);
  }
}
