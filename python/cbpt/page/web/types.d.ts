/** The page's document, as `python/cbpt/page/document/document.py` makes it, and what else modules share. */

export type Maybe<T> = T | null;
/** What an element may hold. */
export type Child = string | number | Node | null | undefined | false | Child[];
export type Column = readonly Maybe<number>[];

export interface Parameter {
  effect: string;
  name: string;
  value: number;
  u: Maybe<number>;
  unit: string;
  text: string;
  at_bound: boolean;
  why_no_u?: Maybe<string>;
}

export interface Model {
  key: string;
  role: string;
  label: string;
  effects: string[];
  model_arcsec: Column;
  residual_arcsec: Column;
  rmse_arcsec: Maybe<number>;
  held_out_rmse_arcsec: Maybe<number>;
  chi2_per_dof: Maybe<number>;
  zero_arcsec: Maybe<number>;
  probability: Maybe<number>;
  tell_tale: string;
  signature_arcsec: Maybe<Column>;
  converged: boolean;
  parameters: Parameter[];
  /** The case with the effects and numbers of the model in it; null where it cannot hold them. */
  case_text?: Maybe<string>;
  why_no_case?: Maybe<string>;
  /** The steps that lead to a model of the user's. */
  ladder?: Rung[];
  numbers: {
    number: string;
    stated: number;
    prior: number;
    value: number;
    u: Maybe<number>;
    shift_sigma: number;
  }[];
}

export interface Candidate {
  effect: string;
  label: string;
  class: string;
  key: string;
  probability: Maybe<number>;
  p_value: Maybe<number>;
  surviving_fraction: Maybe<number>;
  rival: Maybe<string>;
  rival_correlation: Maybe<number>;
  in_answer: boolean;
  is_rival: boolean;
  /** How far a number that is the answer is off. */
  moved?: Maybe<string>;
  tell_tale: string;
  equation: string;
}

export interface Rung {
  added: string;
  label: string;
  key: string;
  effects: string[];
  in_sample_arcsec: number;
  held_out_arcsec: Maybe<number>;
  chi2_per_dof: Maybe<number>;
}

export interface Region {
  label: string;
  region: Record<string, [number, number]>;
  regime: Maybe<string>;
  readings: number;
  share_of_misfit: number;
  bias_arcsec: number;
  p_value: number;
}

export interface Curve {
  label: string;
  level: number;
  preload_N: Maybe<number>;
  branch: Branch;
  torque_Nm: Column;
  angle_arcsec: Record<string, Maybe<Column>>;
}

export type Branch = "up" | "down" | "none";

export interface Readings {
  row: number[];
  run: (string | number)[];
  run_index: number[];
  torque_Nm: number[];
  preload_N: Maybe<number[]>;
  preload_step: Maybe<(string | number)[]>;
  input_angle_deg: Maybe<Column>;
  time_s: Maybe<Column>;
  temperature_degC: Maybe<Column>;
  cycle: Maybe<Column>;
  branch: Branch[];
  level: number[];
  measured_arcsec: number[];
  u_arcsec: Maybe<Column>;
  regime: Maybe<number>[];
  used: boolean[];
  kept: boolean[];
  [column: string]: unknown;
}

/** Where what was typed is no number it stands as it was typed, and the check says so. */
export interface OwnParameter {
  name: string;
  unit: string;
  start: Maybe<number | string>;
  min?: Maybe<number | string>;
  max?: Maybe<number | string>;
}

export interface OwnEffect {
  id: string;
  port: string;
  expression: string;
  parameters: OwnParameter[];
  toml?: string;
}

export interface PageDocument {
  /** Which of the files that a workbench has shown; a report has no such number. */
  opened?: number;
  schema: string;
  product: { name: string; version: string };
  case: { name: string; text: string; sha256: string; kind: string };
  data: {
    name: string;
    rows: number;
    sha256: string;
    notes: string[];
    settings: string[];
    place: string;
  };
  command: string;
  // deno-lint-ignore no-explicit-any
  answer: any;
  answer_key: Maybe<string>;
  readings: Readings;
  regimes: string[];
  columns: { key: string; label: string; unit: string; kind: "number" | "angle" | "category" }[];
  models: Model[];
  candidates: Candidate[];
  library: {
    effect: string;
    label: string;
    class: string;
    tell_tale: string;
    equation: string;
    why_not: Maybe<string>;
  }[];
  ladder: Maybe<{
    rungs: Rung[];
    stop: number;
    stop_says: Maybe<string>;
    held_out_by: string;
    loose: { below: number; says: string };
  }>;
  where: Maybe<{ regions: Region[]; of: string }>;
  curves: Curve[];
  curves_mean_over: string[];
  own: {
    draft: Maybe<OwnEffect>;
    variables: { name: string; meaning: string }[];
    ports: { key: string; meaning: string }[];
  };
  // deno-lint-ignore no-explicit-any
  noise: any;
  // deno-lint-ignore no-explicit-any
  next_run: any;
  // deno-lint-ignore no-explicit-any
  isolability: any;
  // deno-lint-ignore no-explicit-any
  drive: any;
  reasons: Record<string, string>;
}

/** What the server says of the session besides the document. */
export interface Session {
  diagnosing?: boolean;
}

declare global {
  /** The part of plotly.js that the page uses. */
  // deno-lint-ignore no-explicit-any
  var Plotly: any;
}
