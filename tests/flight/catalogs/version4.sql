-- A catalog of version 4, as the program wrote it then.
PRAGMA application_id = 1196639056;
PRAGMA user_version = 4;
BEGIN TRANSACTION;
CREATE TABLE conditions (
        maneuver INTEGER NOT NULL REFERENCES maneuvers(id) ON DELETE CASCADE,
        channel TEXT NOT NULL,
        mean REAL NOT NULL,
        least REAL NOT NULL,
        most REAL NOT NULL,
        PRIMARY KEY (maneuver, channel)
    );
INSERT INTO "conditions" VALUES(1,'V',2.99601052039412074634e+01,2.96000037748654385447e+01,3.03462158037639291303e+01);
INSERT INTO "conditions" VALUES(1,'alpha',4.67446906134970432966e-02,0.0391293638169335,5.39985683040254127451e-02);
INSERT INTO "conditions" VALUES(1,'beta',-6.34841386416286367934e-04,-5.68469286770602669212e-03,4.33483404280876095937e-03);
INSERT INTO "conditions" VALUES(1,'altitude',4.60147996543013846357e+02,4.57058392795443751326e+02,4.61807090297576564811e+02);
INSERT INTO "conditions" VALUES(1,'throttle',5.00018526601539115006e-01,0.497377418576062,5.02995755753546602839e-01);
INSERT INTO "conditions" VALUES(2,'V',2.99775680760992884188e+01,2.9458959886128596394e+01,3.05305411832717297224e+01);
INSERT INTO "conditions" VALUES(2,'alpha',0.0378159847254036,9.82605436397010652271e-03,5.66816805842144250116e-02);
INSERT INTO "conditions" VALUES(2,'beta',5.10067785399995546335e-03,-4.7854722320688457271e-03,1.56986057160800676624e-02);
INSERT INTO "conditions" VALUES(2,'altitude',4.59895451905288268771e+02,4.578129088716720503e+02,4.62322287539442697843e+02);
INSERT INTO "conditions" VALUES(2,'throttle',5.00020669282537078004e-01,4.9754376706529879204e-01,5.02327685113951538653e-01);
INSERT INTO "conditions" VALUES(3,'V',2.99773029174226266499e+01,2.94543890136549570959e+01,3.04736882820690198054e+01);
INSERT INTO "conditions" VALUES(3,'alpha',2.62348247814567087088e-02,-3.31443648082093865123e-03,5.58766436924962583976e-02);
INSERT INTO "conditions" VALUES(3,'beta',-5.08129998527242533745e-03,-1.3962219587281797517e-02,5.49839620579290182939e-03);
INSERT INTO "conditions" VALUES(3,'altitude',4.6007801385999709965e+02,4.55890317425548516902e+02,4.6266801034602752906e+02);
INSERT INTO "conditions" VALUES(3,'throttle',4.99989011095294144659e-01,4.97179403566132160907e-01,5.01675602921374474973e-01);
CREATE TABLE estimates (
        run INTEGER NOT NULL REFERENCES runs(id) ON DELETE CASCADE,
        name TEXT NOT NULL,
        value REAL,
        std REAL,
        cramer_rao REAL,
        status TEXT NOT NULL,
        confounded_with TEXT NOT NULL DEFAULT '[]',
        why TEXT NOT NULL DEFAULT '',
        PRIMARY KEY (run, name)
    );
INSERT INTO "estimates" VALUES(1,'Cm_alpha',-3.50000000000000033306e-01,0.01,0.004,'estimated','[]','');
INSERT INTO "estimates" VALUES(1,'Cm_q',NULL,NULL,NULL,'not-identifiable','["Cm_alpha"]','they look alike');
INSERT INTO "estimates" VALUES(2,'Cm_alpha',-3.60000000000000042188e-01,0.01,0.004,'estimated','[]','');
INSERT INTO "estimates" VALUES(2,'Cm_q',NULL,NULL,NULL,'not-identifiable','["Cm_alpha"]','they look alike');
CREATE TABLE flights (
        id INTEGER PRIMARY KEY,
        name TEXT NOT NULL UNIQUE,
        path TEXT NOT NULL DEFAULT '',
        date TEXT,
        aircraft TEXT NOT NULL DEFAULT '',
        duration REAL,
        takeoff_weight REAL,
        landing_weight REAL,
        fuel REAL,
        notes TEXT NOT NULL DEFAULT '',
        pilot_comments TEXT NOT NULL DEFAULT '',
        facts TEXT NOT NULL DEFAULT '{}'
    , airframe TEXT NOT NULL DEFAULT '');
INSERT INTO "flights" VALUES(1,'2003-05-12-a','flights/2003-05-12-a',NULL,'B777',1.24990000000000009091e+02,NULL,NULL,NULL,'','','{}','');
CREATE TABLE grades (
        id INTEGER PRIMARY KEY,
        maneuver INTEGER NOT NULL REFERENCES maneuvers(id) ON DELETE CASCADE,
        grade TEXT NOT NULL CHECK (grade IN ('A', 'B', 'C', 'D')),
        reasons TEXT NOT NULL DEFAULT '[]',
        given_by TEXT NOT NULL DEFAULT 'program',
        given_at TEXT NOT NULL
    );
INSERT INTO "grades" VALUES(1,1,'B','["turbulence or unrest before the input: q wandered by 26 % of its answer"]','program','2026-11-22T09:05:52.560+00:00');
INSERT INTO "grades" VALUES(2,2,'C','["turbulence or unrest before the input: r wandered by 172 % of its answer"]','program','2026-11-22T09:05:52.560+00:00');
INSERT INTO "grades" VALUES(3,3,'C','["turbulence or unrest before the input: p wandered by 643 % of its answer"]','program','2026-11-22T09:05:52.560+00:00');
INSERT INTO "grades" VALUES(4,2,'D','["pilot sneezed"]','A. Pilot','2026-11-22T09:05:52.565+00:00');
CREATE TABLE inputs (
        maneuver INTEGER NOT NULL REFERENCES maneuvers(id) ON DELETE CASCADE,
        surface TEXT NOT NULL,
        amplitude REAL,
        PRIMARY KEY (maneuver, surface)
    );
INSERT INTO "inputs" VALUES(1,'de',0.0872809352598283);
INSERT INTO "inputs" VALUES(2,'da',1.04906023787316171613e-01);
INSERT INTO "inputs" VALUES(3,'dr',1.74586123217626620895e-01);
CREATE TABLE instrument_errors (
        flight INTEGER NOT NULL REFERENCES flights(id) ON DELETE CASCADE,
        name TEXT NOT NULL,
        value REAL,
        std REAL,
        status TEXT NOT NULL,
        PRIMARY KEY (flight, name)
    );
CREATE TABLE kept_runs (
        id INTEGER PRIMARY KEY,
        label TEXT NOT NULL DEFAULT '',
        made_at TEXT NOT NULL,
        method TEXT NOT NULL,
        axis TEXT NOT NULL,
        aircraft TEXT NOT NULL DEFAULT '',
        flights TEXT NOT NULL DEFAULT '[]',
        request TEXT NOT NULL,
        settings TEXT NOT NULL DEFAULT '{}',
        inputs TEXT NOT NULL DEFAULT '[]',
        versions TEXT NOT NULL DEFAULT '{}',
        result TEXT NOT NULL DEFAULT '{}',
        forgotten_at TEXT
    );
CREATE TABLE maneuvers (
        id INTEGER PRIMARY KEY,
        flight INTEGER NOT NULL REFERENCES flights(id) ON DELETE CASCADE,
        name TEXT NOT NULL,
        t_start REAL NOT NULL,
        t_end REAL NOT NULL,
        kind TEXT NOT NULL,
        amplitude REAL,
        note TEXT NOT NULL DEFAULT '',
        record TEXT NOT NULL,
        stands INTEGER NOT NULL DEFAULT 1,
        UNIQUE (flight, name),
        CHECK (t_start < t_end)
    );
INSERT INTO "maneuvers" VALUES(1,1,'1',59.0,63.95,'doublet',0.0872809352598283,'','{"id": "1", "t_start": 59.0, "t_end": 63.95, "inputs": ["de"], "kind": "doublet", "amplitude": 0.0872809352598283, "grade": "B", "reasons": ["turbulence or unrest before the input: q wandered by 26 % of its answer"], "V": 29.960105203941207, "alpha": 0.04674469061349704, "t_input": 60.0, "t_input_end": 61.04, "amplitudes": {"de": 0.0872809352598283}, "note": ""}',1);
INSERT INTO "maneuvers" VALUES(2,1,'2',71.0,7.59600000000000079563e+01,'doublet',1.04906023787316171613e-01,'','{"id": "2", "t_start": 71.0, "t_end": 75.96000000000001, "inputs": ["da"], "kind": "doublet", "amplitude": 0.10490602378731617, "grade": "C", "reasons": ["turbulence or unrest before the input: r wandered by 172 % of its answer"], "V": 29.97756807609929, "alpha": 0.0378159847254036, "t_input": 72.0, "t_input_end": 73.04, "amplitudes": {"da": 0.10490602378731617}, "note": ""}',1);
INSERT INTO "maneuvers" VALUES(3,1,'3',83.0,8.79600000000000079546e+01,'doublet',1.74586123217626620895e-01,'','{"id": "3", "t_start": 83.0, "t_end": 87.96000000000001, "inputs": ["dr"], "kind": "doublet", "amplitude": 0.17458612321762662, "grade": "C", "reasons": ["turbulence or unrest before the input: p wandered by 643 % of its answer"], "V": 29.977302917422627, "alpha": 0.02623482478145671, "t_input": 84.0, "t_input_end": 85.05, "amplitudes": {"dr": 0.17458612321762662}, "note": ""}',1);
CREATE TABLE models (
        id INTEGER PRIMARY KEY,
        name TEXT NOT NULL UNIQUE,
        parent TEXT,
        content TEXT NOT NULL,
        evidence TEXT NOT NULL DEFAULT '',
        made_at TEXT NOT NULL
    );
INSERT INTO "models" VALUES(1,'b777-2','b777','name = ''b777-2''','better by half','2026-11-22T09:05:52.585+00:00');
CREATE TABLE run_maneuvers (
        run INTEGER NOT NULL REFERENCES runs(id) ON DELETE CASCADE,
        maneuver INTEGER NOT NULL REFERENCES maneuvers(id) ON DELETE CASCADE,
        t_start REAL NOT NULL,
        t_end REAL NOT NULL,
        PRIMARY KEY (run, maneuver)
    );
INSERT INTO "run_maneuvers" VALUES(1,1,59.0,63.95);
INSERT INTO "run_maneuvers" VALUES(2,2,71.0,7.59600000000000079563e+01);
CREATE TABLE runs (
        id INTEGER PRIMARY KEY,
        method TEXT NOT NULL,
        axis TEXT NOT NULL,
        settings TEXT NOT NULL DEFAULT '{}',
        model INTEGER REFERENCES models(id) ON DELETE SET NULL,
        converged INTEGER NOT NULL,
        iterations INTEGER NOT NULL DEFAULT 0,
        fit TEXT NOT NULL DEFAULT '{}',
        warnings TEXT NOT NULL DEFAULT '[]',
        message TEXT NOT NULL DEFAULT '',
        made_at TEXT NOT NULL
    , kept INTEGER REFERENCES kept_runs(id) ON DELETE CASCADE);
INSERT INTO "runs" VALUES(1,'ml','lon','{"lags": 50}',1,1,6,'{"q": {"rms": 0.01}}','["residuals are colored"]','','2026-01-01T00:00:00+00:00',NULL);
INSERT INTO "runs" VALUES(2,'ml','lon','{"lags": 50}',1,1,6,'{"q": {"rms": 0.01}}','["residuals are colored"]','','2026-01-01T00:00:00+00:00',NULL);
CREATE TABLE scores (
        flight INTEGER NOT NULL REFERENCES flights(id) ON DELETE CASCADE,
        card TEXT NOT NULL,
        place INTEGER NOT NULL,
        heading TEXT NOT NULL DEFAULT '',
        good INTEGER NOT NULL,
        flown INTEGER NOT NULL,
        wanted INTEGER NOT NULL,
        PRIMARY KEY (flight, card)
    );
INSERT INTO "scores" VALUES(1,'1',0,'elevator doublets',1,1,3);
CREATE TABLE verdicts (
        id INTEGER PRIMARY KEY,
        flight INTEGER NOT NULL REFERENCES flights(id) ON DELETE CASCADE,
        name TEXT NOT NULL,
        t_input REAL NOT NULL,
        t_end REAL NOT NULL,
        surfaces TEXT NOT NULL,
        kind TEXT NOT NULL,
        V REAL,
        result TEXT NOT NULL,
        advice TEXT NOT NULL DEFAULT '',
        card TEXT NOT NULL DEFAULT '',
        counts INTEGER NOT NULL DEFAULT 0,
        record TEXT NOT NULL,
        UNIQUE (flight, name)
    );
INSERT INTO "verdicts" VALUES(1,1,'M1',60.0,63.95,'de','doublet',30.0,'good','counts','1',1,'{"peak": 0.1}');
CREATE TABLE weights (
        flight INTEGER NOT NULL REFERENCES flights(id) ON DELETE CASCADE,
        response TEXT NOT NULL,
        weight REAL NOT NULL CHECK (weight >= 0),
        PRIMARY KEY (flight, response)
    );
INSERT INTO "weights" VALUES(1,'alpha',5.0);
INSERT INTO "weights" VALUES(1,'q',8.0);
CREATE INDEX maneuvers_by_flight ON maneuvers(flight, t_start);
CREATE INDEX inputs_by_surface ON inputs(surface);
CREATE INDEX conditions_by_channel ON conditions(channel, mean);
CREATE INDEX grades_by_maneuver ON grades(maneuver, id);
CREATE INDEX run_maneuvers_by_maneuver ON run_maneuvers(maneuver);
CREATE INDEX estimates_by_name ON estimates(name);
CREATE INDEX verdicts_by_flight ON verdicts(flight, t_input);
CREATE INDEX runs_by_kept ON runs(kept);
COMMIT;
