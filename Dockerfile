# Images of the Cagefit server for an x86-64 machine, from Debian 12's packages alone. Targets:
#   server   without template making: `cagefit fit --template` and everything after it
#   full     with template making, which needs Open3D: `cagefit fit --vertices`, too
# For example:
#   docker build --target server -t cagefit-server .
#   docker run --read-only -v cagefit:/var/lib/cagefit -p 50051:50051 cagefit-server
# Options of cagefitd follow the image's name or come as CAGEFITD_... variables. Sessions are kept in the volume, templates are
# made in it, and nothing else is written: the root file system may be read-only. Images run as user 10001, and no shell is needed.
#
# deploy/container/check.sh builds and runs both without Docker.

ARG BASE=debian:bookworm-slim
# Tests that must pass: of the programs TEST_PROGRAMS (targets of the build, or "all"), those that match TESTS (as of ctest -R). The
# default takes seconds and needs no templates, data, nginx or PostgreSQL. An empty TESTS runs none.
ARG TEST_PROGRAMS="draco_guard_test e2e_command_line_test e2e_operations_test subdiv_test"
ARG TESTS="^(CommandLineTest[.](HelpAnd|WrongUsage|NoServer|Synth)|OperationsTest[.]Health|DracoGuardTest|LimitSurface)"
ARG JOBS=2

FROM ${BASE} AS sources
RUN dpkg-query -W -f '${Package}\n' >/base-packages
COPY deploy/setup.sh deploy/packages.txt /src/deploy/
RUN /src/deploy/setup.sh
WORKDIR /src
COPY . .

# ccache's folder outlives the build.
FROM sources AS build-server
ARG TEST_PROGRAMS
ARG TESTS
ARG JOBS
RUN --mount=type=cache,target=/root/.cache/ccache deploy/container/build.sh OFF /base-packages /runtime

FROM sources AS build-full
ARG TEST_PROGRAMS
ARG TESTS
ARG JOBS
RUN --mount=type=cache,target=/root/.cache/ccache deploy/container/build.sh ON /base-packages /runtime

FROM ${BASE} AS runtime
RUN useradd --no-log-init --uid 10001 --user-group --no-create-home --home-dir /var/lib/cagefit \
      --shell /usr/sbin/nologin cagefit && \
    install -d -o cagefit -g cagefit -m 0700 /var/lib/cagefit
ARG VERSION=0.1.0
ARG REVISION=""
LABEL org.opencontainers.image.title="Cagefit" \
      org.opencontainers.image.description="Fits a Loop subdivision surface to streams of point clouds: a gRPC service" \
      org.opencontainers.image.licenses="Apache-2.0" \
      org.opencontainers.image.version="${VERSION}" \
      org.opencontainers.image.revision="${REVISION}"
# Health has a port of its own, so that probes need neither certificate nor token.
ENV CAGEFITD_LISTEN=0.0.0.0:50051 \
    CAGEFITD_HEALTH_LISTEN=0.0.0.0:50052 \
    TMPDIR=/var/lib/cagefit
EXPOSE 50051 50052
VOLUME /var/lib/cagefit
USER 10001:10001
STOPSIGNAL SIGTERM
HEALTHCHECK --interval=10s --timeout=6s --start-period=10s CMD ["/usr/local/bin/cagefit", "health", "--server", "127.0.0.1:50052"]
ENTRYPOINT ["/usr/local/bin/cagefitd"]

# That both programs start shows that no library is missing.
FROM runtime AS server
COPY --from=build-server /runtime/ /
RUN ["/usr/local/bin/cagefitd", "--version"]
RUN ["/usr/local/bin/cagefit", "--version"]

FROM runtime AS full
COPY --from=build-full /runtime/ /
RUN ["/usr/local/bin/cagefitd", "--version"]
RUN ["/usr/local/bin/cagefit", "--version"]
