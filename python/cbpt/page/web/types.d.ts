/**
 * The page's document; made from `page/document/types.py` by
 * `python -m cbpt.page.document.typescript`.
 */

// deno-lint-ignore no-explicit-any
export type Any = any;

/** The way of the torque. */
export type Branch = "up" | "down" | "none";

/** What a model is to the answer. */
export type Role = "stated" | "refitted" | "answer" | "rival" | "candidate" | "unknown" | "own";

export type Ends = [number, number];

/** What an effect acts through, or that it is a number of the drive. */
export interface HasClass {
  class: string;
}

/** One parameter of an effect, in the unit that people read. */
export interface Parameter {
  effect: string;
  name: string;
  value: number;
  u: number | null;
  /** Empty where the name ends with it. */
  unit: string;
  value_SI: number;
  name_SI: string;
  at_bound: boolean;
  why_no_u: string | null;
  /** The name, and the value with its uncertainty and unit. */
  text: string;
  /** The value with its uncertainty and unit. */
  value_text: string;
}

/** A number of drive or rig, which moves within its stated uncertainty. */
export interface FittedNumber {
  number: string;
  stated: number;
  prior: number;
  value: number;
  u: number | null;
  shift_sigma: number;
}

/** One step of the ladder. */
export interface Rung {
  added: string;
  label: string;
  key: string;
  effects: string[];
  in_sample_arcsec: number;
  held_out_arcsec: number | null;
  chi2_per_dof: number | null;
}

/** One model of the readings: stated, refitted, or a set of effects that was fitted. */
export interface Model {
  /** The effects joined by +; stated, refitted, unknown. */
  key: string;
  role: Role;
  label: string;
  effects: string[];
  model_arcsec: Column;
  /** Measured less model, with the zeros in the model. */
  residual_arcsec: Column;
  rmse_arcsec: number | null;
  held_out_rmse_arcsec: number | null;
  chi2_per_dof: number | null;
  zero_arcsec: number | null;
  parameters: Parameter[];
  numbers: FittedNumber[];
  probability: number | null;
  tell_tale: string;
  /** What it adds to the drive as stated. */
  signature_arcsec: Column | null;
  /** False: the search did not end; there is neither an uncertainty nor a held-out error. */
  converged: boolean;
  /**
   * The case with effects and refitted numbers in it, as `cbpt fit --out` writes it; null for the
   * drive as stated, which is `case.text`, and where why_no_case says why.
   */
  case_text: string | null;
  why_no_case: string | null;
  /** Of the drive at its load; null where there is none. */
  loop: Loop | null;
  /** The page keeps the steps that lead to a further model with it. */
  ladder?: Rung[];
}

/** A further set of effects, fitted when asked for. */
export interface Choice {
  model: Model;
  /** In the order of `PageDocument.curves`. */
  curves: (Column | null)[];
  ladder: Rung[];
}

export interface Product {
  name: string;
  version: string;
}

export interface CaseFile {
  name: string;
  /** TOML. */
  text: string;
  sha256: string;
  /** ball_drive or torsion_spring. */
  kind: string;
}

/** The table of readings. */
export interface Data {
  name: string;
  rows: number;
  sha256: string;
  notes: string[];
  settings: string[];
  /** line or row: what the readings are counted by. */
  place: string;
  /** Readings that somebody has left out in the workbench. */
  left_out?: number;
}

/** What was measured, on what, by whom; null where nobody said it. */
export interface Head {
  drive: string;
  measured: string;
  rig: string | null;
  author: string | null;
  date: string | null;
}

/** The readings as columns. */
export interface ReadingColumns {
  row: number[];
  run: (string | number)[];
  run_index: number[];
  torque_Nm: number[];
  preload_N: number[] | null;
  preload_step: (string | number)[] | null;
  input_angle_deg: Column | null;
  time_s: Column | null;
  temperature_degC: Column | null;
  cycle: Column | null;
  branch: Branch[];
  /** Index into `data.settings`. */
  level: number[];
  /** Less the offset of its run, so that runs lie on top of each other. */
  measured_arcsec: number[];
  /** The offset of the run: with it the angle is as it was read. */
  zero_arcsec: number[];
  u_arcsec: Column | null;
  /** Index into `regimes`. */
  regime: (number | null)[];
  /** Whether the diagnosis judged it. */
  used: boolean[];
  /** False: it lies far off and counts less. */
  kept: boolean[];
}

/** A column that varies, over which a residual can be mapped. */
export interface MapColumn {
  key: string;
  label: string;
  unit: string;
  kind: "number" | "angle" | "category";
}

/** An effect that is likely, but neither certain nor one of a group of rivals. */
export interface Likely {
  effect: string;
  label: string;
  probability: number;
}

/** A set of effects that the readings leave, with its own numbers. */
export interface Combination {
  label: string;
  /** Of its model; null where something without a name is part of it. */
  key: string | null;
  effects: string[];
  probability: number;
  rmse_arcsec: number;
  held_out_arcsec: number;
  chi2_per_dof: number;
}

/** Readings that share a value or a range of a column. */
export interface RivalGroup {
  label: string;
  readings: number;
  delta_chi2: number;
}

/** Chi-squared of a rival less that of the answer, by the values of a column. */
export interface RivalColumn {
  label: string;
  /** Whether a few values of it make up most of the difference. */
  decides: boolean;
  groups: RivalGroup[];
}

/** What the answer is held against. */
export interface Rival {
  label: string;
  effects: string[];
  log_odds: number;
  delta_chi2: number | null;
  other_log_odds: number | null;
  /** By unit of angle. */
  sentence: Record<string, string>;
  by: RivalColumn[];
}

/** What is left after the answer, against what readings scatter by. */
export interface Remains {
  rms_arcsec: number;
  share_of_misfit: number | null;
  depends_on: string;
  expected_arcsec: number | null;
  expected_from: string | null;
}

/** A number of drive or rig without whose stated uncertainty another answer were as good. */
export interface RestsOn {
  label: string;
  /** Its stated uncertainty. */
  prior: string;
  needed_shift_sigma: number;
}

/**
 * An effect that could be missing; the likeliest stands first. Before them stand numbers that
 * the answer names without ranking them (nulls).
 */
export interface Candidate extends HasClass {
  effect: string;
  label: string;
  /** Of its model; a number that is the answer is part of `refitted`. */
  key: string;
  probability: number | null;
  p_value: number | null;
  surviving_fraction: number | null;
  rival: string | null;
  rival_correlation: number | null;
  in_answer: boolean;
  is_rival: boolean;
  /** Probability that it is at work, where the answer says so. */
  perhaps: number | null;
  /** How far a number that is the answer is off. */
  moved: string | null;
  tell_tale: string;
  equation: string;
}

/** An effect that there is for this kind of reducer. */
export interface LibraryEffect extends HasClass {
  effect: string;
  label: string;
  port: string;
  tell_tale: string;
  equation: string;
  source: string;
  /** Why these readings cannot show it. */
  why_not: string | null;
}

export interface Loose {
  /** Share of the in-sample error. */
  below: number;
  /** What a smaller held-out error means. */
  says: string;
}

export interface Ladder {
  rungs: Rung[];
  /** Index of the answer's rung; of an unknown answer, of the best of the library. */
  stop: number;
  stop_says: string | null;
  held_out_by: string;
  loose: Loose;
}

/** A region of the readings in which the drive as stated fails. */
export interface Region {
  label: string;
  region: Record<string, Ends>;
  regime: string | null;
  readings: number;
  share_of_misfit: number;
  bias_arcsec: number;
  excess_arcsec: number;
  p_value: number;
}

export interface Where {
  regions: Region[];
  /** Key of the model. */
  of: string;
}

/** Where a line is drawn: one for each setting of the rig and each way of the torque. */
export interface Line {
  label: string;
  level: number;
  preload_N: number | null;
  branch: Branch;
  torque_Nm: Column;
}

export interface Curve extends Line {
  /** By key of the model. */
  angle_arcsec: Record<string, Column | null>;
}

/** What was typed stands as it was typed where it is no number, and the check says so. */
export interface OwnParameter {
  name: string;
  unit: string;
  start: number | string | null;
  min?: number | string | null;
  max?: number | string | null;
}

/** An effect of the user's own. */
export interface OwnEffect {
  id: string;
  port: string;
  expression: string;
  parameters: OwnParameter[];
  toml?: string;
}

export interface Variable {
  name: string;
  meaning: string;
}

export interface Port {
  key: string;
  meaning: string;
}

/** What an editor of own effects needs. */
export interface Own {
  draft: OwnEffect | null;
  variables: Variable[];
  ports: Port[];
}

/** Parts of a command line on these files, each quoted for a shell. */
export interface CommandWords {
  case: string;
  data: string;
  /** Flags that say how the table is read; empty where there are none. */
  reading: string;
}

/** A part of the sentence of the answer. */
export interface SentencePart {
  text: string;
  /** Whether it stands in parentheses: the numbers that were found. */
  aside: boolean;
}

/** A number that changed, with its uncertainty as text. */
export interface ChangedNumber {
  effect: string;
  number: string;
  before: string;
  after: string;
  /** up, down, new or gone. */
  direction: string;
  probability: number;
}

export interface UnchangedNumber {
  effect: string;
  number: string;
  value: string;
}

/** One of the tables that were compared. */
export interface MeasuredLevel {
  name: string;
  readings: number;
  rmse_arcsec: number;
  /** Scatter of a typical reading. */
  u_arcsec: number;
  run: number[];
  torque_Nm: Column;
  elastic_angle_arcsec: Column;
}

/** What may have changed, and why it is not told as changed. */
export interface OpenChange {
  effect: string;
  probability: number;
  why: string;
}

/** The loops of one amplitude as they were measured, at both levels. */
export interface MeasuredLoops {
  amplitude_Nm: number;
  /** At zero torque. */
  width_arcsec: number[];
  u_arcsec: (number | null)[];
}

/** A number as each level has it if nothing is shared, as text. */
export interface NumberByItself {
  effect: string;
  number: string;
  values: string[];
}

/** What changed between the readings shown and a second table. */
export interface ChangeSection {
  /** changed, nothing or undecided. */
  kind: string;
  headline: string;
  /** What belongs to the headline; may be empty. */
  rest: string;
  probability: number;
  changed: ChangedNumber[];
  open: OpenChange[];
  unchanged: UnchangedNumber[];
  loops: MeasuredLoops[];
  by_itself: NumberByItself[];
  levels: MeasuredLevel[];
  /** Fitted at both levels. */
  effects: string[];
  remains_arcsec: number | null;
  notes: string[];
}

/** Every number on the page. */
export interface PageDocument {
  /** Which of the files that a workbench has shown; a report has no such number. */
  opened?: number;
  schema: string;
  product: Product;
  case: CaseFile;
  data: Data;
  head: Head;
  /** The command line that makes this report. */
  command: string;
  command_words: CommandWords;
  /** What `cbpt diagnose --json` writes, or null before a diagnosis. */
  answer: Any;
  /** The sentence of the answer by unit of angle; empty before a diagnosis. */
  sentence: Record<string, SentencePart[]>;
  /** What the uncertainty of a reading is, by unit of angle. */
  u_says: Record<string, string>;
  /** The answer against each rival. */
  why: Rival[];
  /** Key of the model that the answer offers; null where none explains the readings. */
  answer_key: string | null;
  perhaps: Likely[];
  /** Those that make up 95 % of the posterior, the most probable first. */
  combinations: Combination[];
  remains: Remains | null;
  rests_on: RestsOn[];
  /** Why the readings do not decide; null where they do. */
  undecided: string | null;
  /** `checks` of `cbpt preflight` and the figures of `loops`; null before a diagnosis. */
  table: Any;
  readings: ReadingColumns;
  /** Names of the contact regimes. */
  regimes: string[];
  /** Of each regime, whether all meshing points carry in it. */
  regimes_full: boolean[];
  columns: MapColumn[];
  models: Model[];
  candidates: Candidate[];
  library: LibraryEffect[];
  ladder: Ladder | null;
  where: Where | null;
  curves: Curve[];
  /** What differs between the readings of one point of a curve: it shows the mean over that. */
  curves_mean_over: string[];
  own: Own;
  /** `answer.noise` with noise_floor_arcsec and noise_floor_of: what it was taken from. */
  noise: Any;
  /** `answer.next_run`. */
  next_run: Any;
  /** What `cbpt isolability` says of this campaign, with the sizes that are shown. */
  isolability: Any;
  drive: DriveSection;
  /** Unit of angle in which a report is opened. */
  unit: string;
  /** Units of angle on the page, each with its size in arcsec. */
  units: Record<string, number>;
  /** How the unit in which a key ends is written: N m for Nm of `torque_Nm`. */
  units_of_keys: Record<string, string>;
  reasons: Record<string, string>;
}

/** Numbers; null where there is none. */
export type Column = (number | null)[];

export interface Load {
  torque_Nm: number;
  preload_N: number | null;
  input_angle_deg: number;
}

export interface DriveSolution {
  status: string;
  message: string;
  elastic_angle_arcsec: number | null;
  deceleration_arcsec: number | null;
  equal_speed_arcsec: number | null;
  torsional_stiffness_Nm_per_arcsec: number | null;
  hold_preload_N: number | null;
}

export interface Finding {
  code: string;
  severity: string;
  pair: string | null;
  message: string;
  remedy: string;
}

export interface PairThresholds {
  hold_N: number | null;
  continuous_N: number | null;
  zero_backlash_N: number | null;
}

/** Preloads, maxima over a period; null: no preload does it. */
export interface DriveThresholds {
  torque_Nm: number;
  drive: PairThresholds;
  deceleration: PairThresholds;
  equal_speed: PairThresholds;
}

/** At the load's preload and input angle. */
export interface AngleCurve {
  torque_Nm: number[];
  elastic_angle_arcsec: Column;
  deceleration_arcsec: Column;
  equal_speed_arcsec: Column;
  status: string[];
}

/**
 * The drive with the effects of a model along one loop of the torque, there and back; the
 * instruments of the rig are left out.
 */
export interface Loop {
  /** From the largest down to the smallest and up again. */
  torque_Nm: number[];
  elastic_angle_arcsec: Column;
  /** Standard uncertainty; null where nothing was fitted. */
  u_arcsec: Column | null;
}

export interface Slider {
  key: string;
  label: string;
  unit: string;
  value: number;
  min: number;
  max: number;
  step: number;
}

export interface Sliders {
  load: Slider[];
  design: Slider[];
}

export interface DrawnLine {
  plate: string;
  kind: string;
  x: number[];
  y: number[];
}

export interface DrawnCircle {
  plate: string;
  kind: string;
  x: number;
  y: number;
  radius: number;
}

export interface DrawnBall {
  number: number;
  x: number;
  y: number;
  radius: number;
}

/** What a meshing point carries; nothing is known without a solution. */
export interface PointState {
  state: string | null;
  role: string | null;
  force_N: number | null;
  in_plane_force_N: number | null;
  deformation_um: number | null;
  gap_um: number | null;
  peak_pressure_GPa: number | null;
}

export interface MeshingPoint extends PointState {
  ball: number;
  diagonal: string;
  plate: string;
  x: number;
  y: number;
  nx: number;
  ny: number;
}

export interface Arrow {
  ball: number;
  diagonal: string;
  x: number;
  y: number;
  dx: number;
  dy: number;
  force_N: number;
}

export interface Centre {
  label: string;
  x: number;
  y: number;
}

export interface Place {
  x: number;
  y: number;
}

export interface Wall extends DrawnLine {
  diagonal: string;
  contact: Place;
  nx: number;
  ny: number;
  state: string | null;
  force_N: number | null;
}

export interface CutBall {
  ball: number;
  ball_radius_mm: number;
  walls: Wall[];
}

export interface Plates {
  output: string;
  other: string;
}

/** The balls of a pair and what they carry. */
export interface LoadedPair {
  pair: string;
  title: string;
  extent_mm: number;
  balls: DrawnBall[];
  points: MeshingPoint[];
  arrows: Arrow[];
  arrow_mm_per_N: number | null;
  torque_Nm: number | null;
  angle_arcsec: number | null;
  carrying: number | null;
  peak_pressure_GPa: number | null;
}

export interface DrawnPair extends LoadedPair {
  plates: Plates;
  lines: DrawnLine[];
  circles: DrawnCircle[];
  centres: Centre[];
  section: CutBall;
}

/** See `drawing`. */
export interface Drawing {
  unit: "mm";
  pairs: DrawnPair[];
}

/** The drive at one load. */
export interface DriveSection {
  /** ball_drive or torsion_spring. */
  kind: string;
  load: Load;
  /** By key of the design sliders. */
  design: Record<string, number>;
  solution: DriveSolution;
  findings: Finding[];
  thresholds: DriveThresholds | null;
  angle_curve: AngleCurve;
  sliders: Sliders;
  drawing: Drawing | null;
  why_no_drawing: string | null;
  /** At a load of choice, with the effects that were asked for. */
  loop?: Loop | null;
}
