# The page of bench-peers from its table; -v work=FOLDER has PART/trials. Logarithmic plots: bytes to the right, mean error upwards.

function cell(text) {
	gsub(/&/, "\\&amp;", text)
	gsub(/</, "\\&lt;", text)
	return text
}

function x_of(bytes) {
	return 45 + 300 * (log(bytes) - log(x_low)) / (log(x_high) - log(x_low))
}

function y_of(error) {
	return 200 - 190 * (log(error) - log(y_low)) / (log(y_high) - log(y_low))
}

# 1, 2 and 5 of each power of ten between low and high
function ticks(low, high, is_x,    decade, step, value) {
	for (decade = -6; decade < 9; decade++)
		for (step = 1; step <= 5; step += step == 1 ? 1 : 3) {
			value = step * 10 ^ decade
			if (value < low || value > high)
				continue
			if (is_x)
				printf "<path d=\"M%.1f 10V200\" class=\"grid\"/><text x=\"%.1f\" y=\"213\" text-anchor=\"middle\">%g</text>", x_of(value), x_of(value), value
			else
				printf "<path d=\"M45 %.1fH345\" class=\"grid\"/><text x=\"41\" y=\"%.1f\" text-anchor=\"end\">%g</text>", y_of(value), y_of(value) + 4, value
		}
}

function plot(part, first, last,    file, line, f, n, i, j, bytes, error, keep) {
	file = work "/" part "/trials"
	x_low = 1e9; x_high = 0; y_low = 1e9; y_high = 0
	n = 0
	while ((getline line < file) > 0) {
		split(line, f, "\t")
		# a trial far off says nothing and would squeeze the rest
		if (f[4] / 1e6 > 30 || f[4] <= 0)
			continue
		bytes[++n] = f[3]
		error[n] = f[4] / 1e6
	}
	close(file)
	for (i = first; i <= last; i++) {
		bytes[n + i - first + 1] = row[i, 4]
		error[n + i - first + 1] = row[i, 5]
	}
	for (i = 1; i <= n + last - first + 1; i++) {
		if (bytes[i] < x_low) x_low = bytes[i]
		if (bytes[i] > x_high) x_high = bytes[i]
		if (error[i] > 0 && error[i] < y_low) y_low = error[i]
		if (error[i] > y_high) y_high = error[i]
	}
	x_low /= 1.1; x_high *= 1.1; y_low /= 1.1; y_high *= 1.1
	printf "<figure><figcaption>%s</figcaption><svg width=\"360\" height=\"220\">", cell(part)
	ticks(x_low, x_high, 1)
	ticks(y_low, y_high, 0)
	for (i = 1; i <= n; i++) {
		keep = 1
		for (j = 1; j <= n && keep; j++)
			keep = j == i || !(bytes[j] <= bytes[i] && error[j] <= error[i] && (bytes[j] < bytes[i] || error[j] < error[i]))
		printf "<circle cx=\"%.1f\" cy=\"%.1f\" r=\"%s\" class=\"%s\"/>", x_of(bytes[i]), y_of(error[i]), (keep ? 3 : 1.5), (keep ? "best" : "trial")
	}
	for (i = first; i <= last; i++)
		if (row[i, 5] > 0)
			printf "<rect x=\"%.1f\" y=\"%.1f\" width=\"8\" height=\"8\" class=\"ours\"/>", x_of(row[i, 4]) - 4, y_of(row[i, 5]) - 4
	print "</svg></figure>"
}

BEGIN {
	print "<!DOCTYPE html>\n<html lang=\"en\"><head><meta charset=\"utf-8\"><title>Cagewright: bench-peers</title><style>"
	print "body { font: 14px/1.4 sans-serif; margin: 1em } table { border-collapse: collapse } th { position: sticky; top: 0; background: #eee }"
	print "td, th { padding: 1px 6px; border: 1px solid #ddd; text-align: right; white-space: nowrap } td:first-child { text-align: left }"
	print "figure { display: inline-block; margin: 6px } svg { font-size: 10px } .grid { stroke: #ddd } .trial { fill: #bbb } .best { fill: #c50 } .ours { fill: #06c }"
	print "tr.larger { background: #fdd }</style></head><body>"
	print "<p>Ours against edge collapse (Lindstrom and Turk) and Draco, whole files, measured against the part. peer: its smallest file with a mean error no larger than ours; both: with a maximum no larger than ours as well; same: its best normals in a file no larger than ours. Errors in thousandths of the longest side, normals in degrees, a dash where there is no such file with up to three vertices to each of our bytes. ratio: our bytes over the peer's. peer_triangles_our_coder: bytes of the peer's triangles, on the same grid, in our coder.</p><table>"
}
{
	printf "<tr%s>", (NR > 1 && $16 != "-" && $16 > 1 ? " class=\"larger\"" : "")
	for (i = 1; i <= NF; i++) {
		printf (NR == 1 ? "<th>%s</th>" : "<td>%s</td>"), cell($i)
		row[NR, i] = $i
	}
	print "</tr>"
}
END {
	print "</table><p>Mean error over bytes. Squares: ours. Dots: the peer, the large ones where no other trial was better in both.</p>"
	for (first = 2; first <= NR; first = last + 1) {
		for (last = first; row[last + 1, 1] == row[first, 1] && last < NR; last++)
			;
		plot(row[first, 1], first, last)
	}
	print "</body></html>"
}
