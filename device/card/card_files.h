// What camera.toml becomes: the configuration files of the services on the card, and a report for the person.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "device/card/card_settings.h"

namespace ldp {

struct CardFile {
  std::filesystem::path path;  // below the folder that the services read (/run/camera)
  std::string text;
  bool secret = false;  // for root alone
};

// ldpd.toml and hostname always. `gallery` where it is to be served and `network` where there is one: empty, for the
// conditions of units. network/*.network for systemd-networkd; wpa_supplicant.conf for a network by radio, of others or
// its own; authorized_keys for sshd, where a key is given.
std::vector<CardFile> card_files(const CardSettings& settings);

// For people, one mistake a line with the line of camera.toml; the same text for the same file and version of programs.
std::string card_report(const CheckedCard& checked, const std::string& version);

}  // namespace ldp
