// SPDX-License-Identifier: Apache-2.0
// The answers of Service, one function a route.
#include <algorithm>
#include <array>
#include <memory>
#include <optional>
#include <string>
#include <utility>

#include "calib/base/json/facts.h"
#include "calib/base/json/strict_json.h"
#include "calib/base/json/utf8.h"
#include "tools/serve/cookie.h"
#include "tools/serve/event_stream.h"
#include "tools/serve/reply.h"
#include "tools/serve/service.h"
#include <fmt/format.h>

namespace panelcal::serve {
namespace {

using nlohmann::json;

constexpr std::string_view kJsonType = "application/json";

/// A body that is one object.
Expected<json> parse_object(const Request& request) {
  PANELCAL_TRY(json document, internal::parse_strict_json(request.body, "request"));
  if (document.is_object()) return document;
  return failure({Code::JsonSyntax, {"request", 1, 1}, "", "one object"});
}

/// A text of the object; empty if it is absent or no text.
std::string text_of(const json& object, const char* key) {
  const auto found = object.find(key);
  return found != object.end() && found->is_string() ? found->get<std::string>() : std::string();
}

/// True of characters that show nothing and turn the text around them: U+200B to U+200F, U+2028 to
/// U+202E, U+2060 to U+206F, U+FEFF.
bool is_invisible(std::string_view character) {
  if (character == "\xef\xbb\xbf") return true;
  if (character.size() != 3 || character[0] != '\xe2') return false;
  const auto last = static_cast<unsigned char>(character[2]);
  if (character[1] == '\x81') return last >= 0xa0 && last <= 0xaf;
  const bool is_space = last >= 0x8b && last <= 0x8f;
  return character[1] == '\x80' && (is_space || (last >= 0xa8 && last <= 0xae));
}

/// A name as people have them: valid UTF-8 without control characters, neither empty nor long.
bool is_name(std::string_view text, std::size_t max_characters) {
  if (text.empty() || escaped_controls(text) != text) return false;
  for (std::size_t n_characters = 1; !text.empty(); ++n_characters) {
    const std::size_t n = utf8_length(text);
    if (n == 0 || n_characters > max_characters || is_invisible(text.substr(0, n))) return false;
    text.remove_prefix(n);
  }
  return true;
}

bool is_small_sign(char c) {
  return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '-' ||
         c == '_' || c == '.';
}

bool is_job_id(std::string_view text) {
  return !text.empty() && text.size() <= 64 && text.front() != '.' &&
         std::ranges::all_of(text, is_small_sign);
}

struct JobFile {
  std::string_view name;
  std::string_view content_type;
  Policy policy;
  bool is_download;
};

constexpr std::array<JobFile, 4> kJobFiles = {{
    {"report.html", "text/html; charset=utf-8", Policy::Report, false},
    {"facts.json", "application/json", Policy::Nothing, false},
    {"measurements.jsonl", "application/octet-stream", Policy::Nothing, true},
    {"output", "application/octet-stream", Policy::Nothing, true},
}};
constexpr JobFile kJobPicture = {"", "image/jpeg", Policy::Nothing, false};

bool is_picture_name(std::string_view name) {
  constexpr std::string_view kBegin = "picture-";
  constexpr std::string_view kEnd = ".jpg";
  if (!name.starts_with(kBegin) || !name.ends_with(kEnd)) return false;
  if (name.size() <= kBegin.size() + kEnd.size() || name.size() > 30) return false;
  const auto digits = name.substr(kBegin.size(), name.size() - kBegin.size() - kEnd.size());
  return std::ranges::all_of(digits, [](char c) { return c >= '0' && c <= '9'; });
}

/// Null: a name that no job has.
const JobFile* job_file_of(std::string_view name) {
  if (is_picture_name(name)) return &kJobPicture;
  const auto* const found = std::ranges::find(kJobFiles, name, &JobFile::name);
  return found == kJobFiles.end() ? nullptr : found;
}

Header session_header(const Request& request,
                      const std::string& session,
                      std::chrono::seconds length) {
  // Of a proxy that ends TLS the origin tells.
  const bool is_https = request.is_encrypted || request.header("origin").starts_with("https://");
  return {"Set-Cookie",
          fmt::format("{}={}; Path=/; HttpOnly; SameSite=Strict; Max-Age={}{}",
                      session_cookie(request),
                      session,
                      length.count(),
                      is_https ? "; Secure" : "")};
}

}  // namespace

Response Service::page(const Request& /*request*/, const Target& /*target*/) {
  return reply(200, "text/html; charset=utf-8", std::string(parts_.front_end.page), Policy::Screen);
}

Response Service::script(const Request& /*request*/, const Target& /*target*/) {
  return reply(200, "text/javascript; charset=utf-8", std::string(parts_.front_end.script));
}

Response Service::style(const Request& /*request*/, const Target& /*target*/) {
  return reply(200, "text/css; charset=utf-8", std::string(parts_.front_end.style));
}

Response Service::state(const Request& /*request*/, const Target& /*target*/) {
  Response response = reply(200, kJsonType, *parts_.announcer.latest().state);
  // So that the screen offers to log out.
  if (parts_.login != nullptr) response.headers.push_back({"X-Panelcal-Session", "open"});
  return response;
}

Response Service::events(const Request& request, const Target& target) {
  const auto name = target.parameters.find("stream");
  // A stream is no way to go on looking when the session is over.
  const auto may_look = [this, request] { return !check_login(request); };
  auto stream = EventStream::open(parts_.announcer,
                                  parts_.controls,
                                  name == target.parameters.end() ? std::string() : name->second,
                                  may_look);
  if (stream == nullptr) {
    return error_reply(
        503, "too many screens", fmt::format("at most {} at a time", Announcer::kMaxScreens));
  }
  Response response = reply(200, "text/event-stream", "");
  response.events = std::move(stream);
  return response;
}

Response Service::picture(const Request& /*request*/, const Target& /*target*/) {
  ServedMachine::Picture picture = parts_.machine.picture();
  if (picture.number == 0) return error_reply(404, "no picture yet", "");
  Response response = reply(200, "image/jpeg", std::move(picture.jpeg));
  response.headers.push_back({"X-Panelcal-Frame", std::to_string(picture.number)});
  return response;
}

Response Service::job_file(const Request& /*request*/, const Target& target) {
  std::string_view rest = target.path;
  rest.remove_prefix(std::string_view("/api/jobs/").size());
  const std::size_t slash = std::min(rest.find('/'), rest.size());
  const std::string id(rest.substr(0, slash));
  const std::string name(rest.substr(std::min(slash + 1, rest.size())));
  if (job_file_of(name) == nullptr || !is_job_id(id)) {
    return error_reply(404, fmt::format("no file of a job: {}", quoted(rest)), "");
  }
  return send_file(id, name);
}

/// What the night, or a calibration by day, has found.
Response Service::calibration_page(const Request& /*request*/, const Target& /*target*/) {
  return send_file("night", "report.html");
}

Response Service::send_file(const std::string& job_id, const std::string& name) {
  if (n_files_->fetch_add(1) >= kMaxFiles) {
    n_files_->fetch_sub(1);
    return error_reply(503, "too many files on their way", "another try in a moment");
  }
  const std::shared_ptr<void> permit(n_files_.get(), [n = n_files_](void*) { n->fetch_sub(1); });
  Expected<std::string> bytes = parts_.machine.job_file(job_id, name);
  if (!bytes) {
    Response refusal = error_reply(bytes.error());
    refusal.status = 404;
    return refusal;
  }
  const JobFile& file = *job_file_of(name);
  Response response = reply(200, file.content_type, *std::move(bytes), file.policy);
  if (file.is_download) response.headers.push_back({"Content-Disposition", "attachment"});
  response.permit = permit;
  return response;
}

Response Service::log_in(const Request& request, const Target& /*target*/) {
  if (parts_.login == nullptr) return reply(200, kJsonType, "{}\n");
  const Expected<json> body = parse_object(request);
  if (!body) return error_reply(body.error());
  const Login::Answer answer =
      parts_.login->log_in(text_of(*body, "token"), request.peer, parts_.now());
  if (answer.wait.count() > 0) {
    Response refusal = error_reply(
        429, "too many wrong tokens", fmt::format("another try in {} s", answer.wait.count()));
    refusal.headers.push_back({"Retry-After", std::to_string(answer.wait.count())});
    refusal.delay = std::chrono::seconds(1);
    return refusal;
  }
  if (answer.session.empty()) {
    return error_reply(401, "wrong token", "the token that panelcal serve printed");
  }
  Response response = reply(200, kJsonType, "{}\n");
  response.headers.push_back(
      session_header(request, answer.session, std::chrono::seconds(Login::kSessionLength)));
  return response;
}

/// Ends the session and gives the controls back, if this screen has them.
Response Service::log_out(const Request& request, const Target& /*target*/) {
  if (parts_.controls.give_back(request.header("x-panelcal-controls"))) {
    parts_.announcer.announce_controls();
  }
  Response response = reply(200, kJsonType, "{}\n");
  if (parts_.login == nullptr) return response;
  parts_.login->log_out(cookie_of(request.header("cookie"), session_cookie(request)));
  response.headers.push_back(session_header(request, "", std::chrono::seconds(0)));
  return response;
}

Response Service::change_controls(const Request& request, const Target& /*target*/) {
  constexpr std::size_t kMaxName = 60;         // characters
  constexpr std::size_t kMaxName_bytes = 100;  // as journals of jobs take them
  const Expected<json> body = parse_object(request);
  if (!body) return error_reply(body.error());
  const std::string key(request.header("x-panelcal-controls"));
  const auto take = body->find("take");
  if (take == body->end() || !take->is_boolean()) {
    return error_reply(400, "\"take\" missing", "true or false");
  }
  if (!take->get<bool>()) {
    if (!parts_.controls.give_back(key)) {
      return error_reply(403, "controls held by another screen, or free", "");
    }
    parts_.announcer.announce_controls();
    return reply(200, kJsonType, "{}\n");
  }
  const std::string name = text_of(*body, "name");
  if (!is_name(name, kMaxName) || name.size() > kMaxName_bytes) {
    return error_reply(400,
                       fmt::format("\"name\" not usable: {}", quoted(name)),
                       "the name of a person, at most 60 characters");
  }
  const auto taken = parts_.controls.take({name, key, text_of(*body, "from")}, parts_.now());
  if (!taken) {
    return error_reply(409,
                       fmt::format("controls held by \"{}\"", parts_.controls.holder()),
                       "wait until they are given back, or take them over");
  }
  parts_.announcer.announce_controls();
  facts::Json document;
  document["key"] = *taken;
  return reply(200, kJsonType, facts::text(document));
}

Response Service::command(const Request& request, const Target& /*target*/) {
  const Expected<json> body = parse_object(request);
  if (!body) return error_reply(body.error());
  if (text_of(*body, "do").empty()) {
    return error_reply(400, "\"do\" missing", "a command, such as {\"do\":\"start\"}");
  }
  const Expected<void> done = parts_.controls.while_held(
      request.header("x-panelcal-controls"), parts_.now(), [&](const std::string& who) {
        return parts_.machine.command(request.body, who);
      });
  return done ? reply(200, kJsonType, "{}\n") : error_reply(done.error());
}

Response Service::add_program(const Request& request, const Target& target) {
  constexpr std::size_t kMaxName = 128;  // characters
  const auto found = target.parameters.find("name");
  const std::string name = found == target.parameters.end() ? std::string() : found->second;
  if (!is_name(name, kMaxName) || name.front() == '.' || name.find_first_of("/\\") != name.npos) {
    return error_reply(400,
                       fmt::format("name of a program not usable: {}", quoted(name)),
                       "a name of at most 128 characters without / and \\, not hidden");
  }
  // It moves nothing and may take seconds, in which the holder must be able to stop.
  const Expected<void> done = parts_.machine.add_program(name, request.body);
  return done ? reply(200, kJsonType, "{}\n") : error_reply(done.error());
}

}  // namespace panelcal::serve
