// Makes a fit and takes its mesh by the types that openapi-typescript generates.
import createClient from "openapi-fetch";
import type { components, paths } from "./ipfit.js";

declare const process: { argv: string[] };
const corners = [[1, 0, 0], [-1, 0, 0], [0, 1, 0], [0, -1, 0], [0, 0, 1], [0, 0, -1]];
const s = Math.sqrt(1 / 3);
const faces = [[s, s, s], [-s, s, s], [s, -s, s], [s, s, -s], [-s, -s, s], [-s, s, -s], [s, -s, -s], [-s, -s, -s]];
const points = [...corners, ...faces];

const client = createClient<paths>({ baseUrl: process.argv[2] ?? "" });
const body: components["schemas"]["FitRequest"] = { points, normals: points, options: { max_degree: 2 } };
const fitted = await client.POST("/v1/fits", { params: { header: { Prefer: "wait=60" } }, body });
if (fitted.error !== undefined) throw new Error(fitted.error.detail);
const fit = fitted.data as components["schemas"]["FitResource"]; // Accept decides; a file may be the answer, too

const path = { fit_id: fit.id };
const mesh = await client.GET("/v1/fits/{fit_id}/mesh", {
  params: { path, query: { format: "ply", resolution: 24 } },
  parseAs: "arrayBuffer",
});
if (mesh.error !== undefined) throw new Error(mesh.error.detail);
const missing = await client.GET("/v1/fits/{fit_id}", { params: { path: { fit_id: "0".repeat(32) } } });

console.log(JSON.stringify({
  status: fit.status,
  degree: fit.polynomial?.degree,
  mesh: new TextDecoder().decode(mesh.data.slice(0, 3)),
  missing: missing.error?.type,
}));
