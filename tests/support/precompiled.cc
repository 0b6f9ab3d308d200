// SPDX-License-Identifier: Apache-2.0
// No test: headers are precompiled with it.
int main() {
}
