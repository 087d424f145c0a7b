
CREATE TABLE run (
  id INTEGER PRIMARY KEY CHECK (id = 1),
  run_id INTEGER NOT NULL,
  name TEXT NOT NULL,
  seed INTEGER NOT NULL,
  fingerprint TEXT NOT NULL,
  build TEXT NOT NULL,
  created_at REAL NOT NULL,
  config_text TEXT NOT NULL,
  config BLOB NOT NULL,
  experiment BLOB NOT NULL,
  seal BLOB NOT NULL
) STRICT;
CREATE TABLE progress (
  id INTEGER PRIMARY KEY CHECK (id = 1),
  epoch INTEGER NOT NULL,
  state TEXT NOT NULL,
  updated_at REAL NOT NULL,
  seal BLOB NOT NULL
) STRICT;
CREATE TABLE assets (
  id TEXT PRIMARY KEY,
  kind TEXT NOT NULL,
  name TEXT NOT NULL,
  packed BLOB NOT NULL,
  seal BLOB NOT NULL
) STRICT;
CREATE TABLE generations (
  generation INTEGER PRIMARY KEY,
  best REAL NOT NULL,
  mean REAL NOT NULL,
  deviation REAL NOT NULL,
  species INTEGER NOT NULL,
  threshold REAL NOT NULL,
  best_genome INTEGER NOT NULL,
  links REAL NOT NULL,
  evaluations INTEGER NOT NULL,
  trials INTEGER NOT NULL,
  seconds REAL NOT NULL,
  committed_at REAL NOT NULL,
  seal BLOB NOT NULL
) STRICT;
CREATE TABLE species (
  generation INTEGER NOT NULL,
  species INTEGER NOT NULL,
  age INTEGER NOT NULL,
  last_improved INTEGER NOT NULL,
  size INTEGER NOT NULL,
  best REAL NOT NULL,
  mean REAL NOT NULL,
  seal BLOB NOT NULL,
  PRIMARY KEY (generation, species)
) STRICT, WITHOUT ROWID;
CREATE TABLE bests (
  generation INTEGER PRIMARY KEY,
  genome INTEGER NOT NULL,
  fitness REAL NOT NULL,
  genotype BLOB NOT NULL,
  network BLOB NOT NULL,
  seal BLOB NOT NULL
) STRICT;
CREATE TABLE populations (
  generation INTEGER PRIMARY KEY,
  state BLOB NOT NULL,
  seal BLOB NOT NULL
) STRICT;
CREATE TABLE evaluations (
  generation INTEGER NOT NULL,
  genome INTEGER NOT NULL,
  measurements BLOB NOT NULL,
  seal BLOB NOT NULL,
  PRIMARY KEY (generation, genome)
) STRICT, WITHOUT ROWID;
CREATE TABLE poisons (
  generation INTEGER NOT NULL,
  genome INTEGER NOT NULL,
  reason TEXT NOT NULL,
  network BLOB NOT NULL,
  trials BLOB NOT NULL,
  seal BLOB NOT NULL,
  PRIMARY KEY (generation, genome)
) STRICT;
CREATE TABLE validations (
  generation INTEGER NOT NULL,
  genome INTEGER NOT NULL,
  trials INTEGER NOT NULL,
  successes INTEGER NOT NULL,
  fitness REAL NOT NULL,
  lift_trials INTEGER NOT NULL,
  lifts INTEGER NOT NULL,
  seal BLOB NOT NULL,
  PRIMARY KEY (generation, genome)
) STRICT;
CREATE TABLE champion (
  id INTEGER PRIMARY KEY CHECK (id = 1),
  champion BLOB NOT NULL,
  seal BLOB NOT NULL
) STRICT;
CREATE TABLE events (
  id INTEGER PRIMARY KEY AUTOINCREMENT,
  time REAL NOT NULL,
  severity INTEGER NOT NULL,
  kind TEXT NOT NULL,
  text TEXT NOT NULL,
  seal BLOB NOT NULL
) STRICT;
CREATE TABLE workers (
  identity TEXT PRIMARY KEY,
  host TEXT NOT NULL,
  build TEXT NOT NULL,
  state TEXT NOT NULL,
  slots INTEGER NOT NULL,
  first_seen REAL NOT NULL,
  last_seen REAL NOT NULL,
  tasks INTEGER NOT NULL,
  trials INTEGER NOT NULL,
  seal BLOB NOT NULL
) STRICT;
