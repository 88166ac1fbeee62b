// The operator stations, driven as people would: what panel.test.mjs and more.test.mjs ask of them.
import { until } from "./support.mjs";

export const TELEOPERATION = "scenarios/teleoperation.json";

/** A page of 1280x800 before a station, with its layout shown. */
export const STATION = { viewport: { width: 1440, height: 900 } };

export async function arm(server, name) {
  return (await server.ask("GET", `/v1/arms/${name}`)).state;
}

/** An arm has moved by what is done. */
export async function moved(server, name, act) {
  const { q_commanded: before } = await arm(server, name);
  await act();
  return until(
    `'${name}' moves`,
    async () => (await arm(server, name)).q_commanded,
    (now) => now.some((one, i) => Math.abs(one - before[i]) > 1e-4),
  );
}

/**
 * An arm stands, by two looks at its set point, which may change in its last bits.
 * @param least  rad: less counts as nothing; more where the arm follows what is measured
 */
export const stood = (server, name, { seconds = 3, least = 1e-9 } = {}) =>
  until(
    `'${name}' rests: rad in 60 ms`,
    async () => {
      const { q_commanded: before } = await arm(server, name);
      await new Promise((resolve) => setTimeout(resolve, 60));
      const { q_commanded: after } = await arm(server, name);
      return Math.max(...before.map((one, i) => Math.abs(one - after[i])));
    },
    (difference) => difference <= least,
    seconds,
  );
