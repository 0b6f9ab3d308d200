# SPDX-License-Identifier: Apache-2.0
import sqlite3
sqlite3.connect("drill1.ledger").executescript("CREATE TABLE t(x); INSERT INTO t VALUES (1)")
